#include "engine/tail/wave_directions.h"

#include <cmath>
#include <glm/mat3x3.hpp>

#include "engine/base/sampling.h"

namespace aula {
namespace {

/// A rotation, uniform over all of them (Shoemake 1992), as the matrix of a random quaternion.
glm::mat3 random_rotation(std::uint64_t seed) {
    RandomStream random(seed);
    const float u = random.uniform();
    const Turn a(random.uniform());
    const Turn b(random.uniform());
    const float r = std::sqrt(1 - u);
    const float s = std::sqrt(u);
    const float x = r * a.sine;
    const float y = r * a.cosine;
    const float z = s * b.sine;
    const float w = s * b.cosine;
    return {{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
            {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
            {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
}

}  // namespace

// The images of one point under the 24 rotations of the cube: even permutations of the coordinates
// with an even number of minus signs, then odd ones with an odd number. The first half is its
// images under the rotations of a tetrahedron, over which polynomials up to degree 2 have the means
// over the sphere. No two are opposite, so that each is another shift along any displacement.
std::array<Vec3, kPlaneWaves> wave_directions(std::uint64_t seed) {
    constexpr std::array<float, 3> kPoint{0.866246818F, 0.422518654F, 0.266635402F};
    const glm::mat3 rotation = random_rotation(seed);
    std::array<Vec3, kPlaneWaves> directions{};
    for (std::size_t i = 0; i < kPlaneWaves; ++i) {
        const std::size_t first = i % 3;
        const bool is_odd = i >= kPlaneWaves / 2;
        const float x = kPoint[first];
        const float y = kPoint[(first + (is_odd ? 2 : 1)) % 3];
        const float z = kPoint[(first + (is_odd ? 1 : 2)) % 3];
        const float sign_x = i / 3 % 2 == 0 ? 1 : -1;
        const float sign_y = i / 6 % 2 == 0 ? 1 : -1;
        const float sign_z = sign_x * sign_y * (is_odd ? -1 : 1);
        directions[i] = rotation * Vec3(sign_x * x, sign_y * y, sign_z * z);
    }
    return directions;
}

}  // namespace aula
