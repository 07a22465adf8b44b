#include "apps/aula/arguments/arguments.h"

#include <string>
#include <vector>

#include "aula/exception.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

/// The input contains the arguments, one per line.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::vector<std::string> lines{"aula"};
    std::string line;
    for (std::size_t i = 0; i < size && data[i] != '\0'; ++i) {
        if (data[i] == '\n') {
            lines.push_back(std::exchange(line, {}));
        } else {
            line += static_cast<char>(data[i]);
        }
    }
    if (!line.empty()) lines.push_back(line);
    std::vector<const char*> argv;
    for (const std::string& argument : lines) argv.push_back(argument.c_str());
    argv.push_back(nullptr);
    try {
        const Arguments arguments = read_arguments(static_cast<int>(lines.size()), argv.data());
        Scene scene;
        scene.sources.emplace_back().name = "voice";
        for (const auto& change : arguments.scene_changes) change(scene);
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
    return 0;
}
