#include <catch2/catch.hpp>
#include <limits>

#include "aula/audio/realtime.h"

using namespace aula;

namespace {

float product(float a, float b) {
    // Volatile: computed at run time.
    const volatile float x = a;
    const volatile float y = b;
    return x * y;
}

constexpr float kLeast = std::numeric_limits<float>::min();
constexpr float kDenormal = kLeast / 2;

}  // namespace

TEST_CASE("While denormals are flushed, results and operands below the least number are zero") {
    CHECK(product(kLeast, 0.5F) == kDenormal);
    CHECK(product(kDenormal, 8) == 4 * kLeast);
#if defined(__SSE__) || defined(__aarch64__)
    {
        const FlushDenormals flush;
        CHECK(product(kLeast, 0.5F) == 0);
        CHECK(product(kDenormal, 8) == 0);
        CHECK(product(kLeast, 2) == 2 * kLeast);
        {
            const FlushDenormals nested;
            CHECK(product(kLeast, 0.5F) == 0);
        }
        CHECK(product(kDenormal, 8) == 0);
    }
#endif
    CHECK(product(kLeast, 0.5F) == kDenormal);
    CHECK(product(kDenormal, 8) == 4 * kLeast);
}
