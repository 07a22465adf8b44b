#include <algorithm>
#include <cmath>
#include <cstdio>

#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    // Output to standard output goes to this file.
    [[maybe_unused]] static const auto* const printed =
        std::freopen((test::fuzz_folder().path() / "stdout").c_str(), "w", stdout);
    const auto file = test::input_file("sound", data, size);
    try {
        const SoundClip clip = read_sound(file, 48000);
        test::expect(!clip.samples.empty(), "a sound has samples");
        test::expect(std::all_of(clip.samples.begin(), clip.samples.end(),
                                 [](float x) { return std::isfinite(x); }),
                     "samples are finite");
    } catch (const InputError& error) {
        test::expect_one_line(error.what());
    }
    test::expect(std::ftell(stdout) == 0, "nothing is printed");
    return 0;
}
