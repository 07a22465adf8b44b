#pragma once

#include <array>
#include <cmath>

#include "aula/engine/directivity.h"
#include "aula/exception.h"
#include "tests/fuzz/fuzz_target.h"

namespace aula::test {

/// Makes a directivity. It must be usable, or be refused with one line.
template <class Make>
int make_any_directivity(const Make& make) {
    try {
        const Directivity directivity = make();
        for (const Vec3& direction :
             {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(-0.6F, -0.64F, 0.48F)})
            for (const float factor : directivity.factor(direction).value)
                expect(factor >= 0 && std::isfinite(factor), "factors are finite energies");
    } catch (const InputError& error) {
        expect_one_line(error.what());
    }
    return 0;
}

}  // namespace aula::test
