#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "audio/spatial/hrtf.h"
#include "aula/exception.h"
#include "tests/fuzz/fuzz_target.h"

namespace aula::test {

/// Makes an HRTF from any measurements or file. It must be usable, or be refused with one line.
template <class Input>
int make_any_hrtf(const Input& input) {
    try {
        const Hrtf hrtf(input, 48000);
        for (const auto& direction : {std::array{1.0F, 0.0F, 0.0F}, std::array{0.0F, 0.6F, -0.8F}})
            for (const Hrtf::Ear& ear : hrtf.ears(direction)) {
                expect(ear.delay_s >= 0 && ear.delay_s < 0.01, "a delay is below 10 ms");
                expect(std::all_of(ear.minimum_phase.begin(), ear.minimum_phase.end(),
                                   [](float x) { return std::isfinite(x); }),
                       "responses are finite");
            }
    } catch (const InputError& error) {
        expect_one_line(error.what());
    }
    return 0;
}

}  // namespace aula::test
