#include <string>

#include "apps/room/edit/scene_writer.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/input/json.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/names_in_input.h"

using namespace aula;

/// Scenes may refer to room.obj and voice.wav in their folder.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    [[maybe_unused]] static const bool written = [] {
        test::fuzz_folder().write("room.obj",
                                  "usemtl brick\nv 0 0 0\nv 4 0 0\nv 0 3 0\nv 0 0 2\n"
                                  "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        test::fuzz_folder().write("voice.wav", "sounds are not read with the scene");
        return true;
    }();
    try {
        const std::string text(reinterpret_cast<const char*>(data), size);
        if (test::names_other_folder(parse_json(text, "scene.json"))) return 0;
        const LoadedScene loaded = load_scene(test::input_file("scene.json", data, size));
        for (const std::string& warning : loaded.warnings) test::expect_one_line(warning);
        // A saved scene can be loaded.
        const auto folder = test::fuzz_folder().path();
        const std::string saved = edited_scene_text(loaded, loaded.scene, folder, folder);
        load_scene(test::fuzz_folder().write("saved.json", saved));
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
    return 0;
}
