#include "apps/window/view/lobe.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "apps/window/view/curves.h"

namespace aula {

namespace {

constexpr std::size_t kPolar = 24;    ///< steps from the front to the back
constexpr std::size_t kAround = 36;   ///< steps around the front axis
constexpr std::size_t kMeridian = 3;  ///< every third step around has a line
constexpr std::size_t kCircle = 4;    ///< every fourth polar step has a line

/// Front to back along x, as the axis of most lobes.
Vec3 grid_direction(std::size_t polar, std::size_t around) {
    const float from_front_rad =
        std::numbers::pi_v<float> * static_cast<float>(polar) / static_cast<float>(kPolar);
    const float around_rad =
        2 * std::numbers::pi_v<float> * static_cast<float>(around) / static_cast<float>(kAround);
    return {std::cos(from_front_rad), std::sin(from_front_rad) * std::cos(around_rad),
            std::sin(from_front_rad) * std::sin(around_rad)};
}

}  // namespace

std::vector<std::array<Vec3, 2>> lobe_lines(const Directivity& directivity, std::size_t band,
                                            const Vec3& source, const glm::mat3& rotation,
                                            float radius_m) {
    std::array<std::array<Vec3, kAround>, kPolar + 1> points;
    std::array<std::array<float, kAround>, kPolar + 1> pressures;
    float loudest = 1e-10F;
    for (std::size_t polar = 0; polar <= kPolar; ++polar) {
        for (std::size_t around = 0; around < kAround; ++around) {
            const Bands energy = directivity.factor(grid_direction(polar, around));
            pressures[polar][around] = static_cast<float>(std::sqrt(band_energy(energy, band)));
            loudest = std::max(loudest, pressures[polar][around]);
        }
    }
    for (std::size_t polar = 0; polar <= kPolar; ++polar)
        for (std::size_t around = 0; around < kAround; ++around)
            points[polar][around] = source + radius_m * pressures[polar][around] / loudest *
                                                 (rotation * grid_direction(polar, around));
    std::vector<std::array<Vec3, 2>> lines;
    for (std::size_t polar = 0; polar < kPolar; ++polar)
        for (std::size_t around = 0; around < kAround; around += kMeridian)
            lines.push_back({points[polar][around], points[polar + 1][around]});
    for (std::size_t polar = kCircle; polar < kPolar; polar += kCircle)
        for (std::size_t around = 0; around < kAround; ++around)
            lines.push_back({points[polar][around], points[polar][(around + 1) % kAround]});
    return lines;
}

}  // namespace aula
