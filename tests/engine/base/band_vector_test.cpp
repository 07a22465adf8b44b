#include "engine/base/band_vector.h"

#include <array>
#include <catch2/catch.hpp>

#include "engine/base/sampling.h"

using namespace aula;

TEST_CASE("band vectors have reproducible sums, to the bit, and right maxima") {
    RandomStream random(1);
    for (int i = 0; i < 200; ++i) {
        std::array<Bands, 8> whole;
        std::array<BandVector, 8> wholes;
        std::array<BandVector, 8> parts;
        for (std::size_t k = 0; k < 8; ++k) {
            for (float& energy : whole[k].value) energy = random.uniform();
            wholes[k] = load_bands(whole[k]);
            parts[k] = wholes[k] * random.uniform();
        }
        const BandVector sums = sums_over_bands(wholes);
        const BandVector less = sums_over_bands(parts);
        const BandVector maxima = maxima_over_bands(wholes);
        for (std::size_t k = 0; k < 8; ++k) {
            CHECK(sums[k] == whole[k].sum());
            CHECK(maxima[k] == whole[k].max());
            // Rounding cannot make a part larger than the whole.
            CHECK(less[k] <= sums[k]);
            // The same, in each band of one vector.
            const BandVector sum = sum_of_bands(wholes[k]);
            const BandVector largest = max_of_bands(wholes[k]);
            for (int b = 0; b < 8; ++b) {
                CHECK(sum[b] == sums[k]);
                CHECK(largest[b] == maxima[k]);
            }
        }
    }
}
