#include <algorithm>
#include <cmath>

#include "audio/base/error.h"
#include "audio/spatial/hrtf.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto file = test::input_file("set.sofa", data, size);
    try {
        const Hrtf hrtf(file, 48000);
        for (const auto& direction : {std::array{1.0F, 0.0F, 0.0F}, std::array{0.0F, 0.6F, -0.8F}})
            for (const Hrtf::Ear& ear : hrtf.ears(direction)) {
                test::expect(ear.delay_s >= 0 && ear.delay_s < 1, "a delay is below a second");
                test::expect(std::all_of(ear.minimum_phase.begin(), ear.minimum_phase.end(),
                                         [](float x) { return std::isfinite(x); }),
                             "responses are finite");
            }
    } catch (const AudioInputError& error) {
        test::expect_one_line(error.what());
    }
    return 0;
}
