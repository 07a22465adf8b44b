#include "engine/model/unit_guess.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace aula {

std::optional<LengthUnit> guess_unit(const glm::dvec3& size) {
    constexpr double kLowest_m = 1.8;  // a person stands
    constexpr double kHighest_m = 60;  // the highest nave has 48 m
    constexpr double kWidest_m = 300;  // the longest halls of fairs
    const auto fits = [&](double metres, double lowest_m) {
        return size.z * metres >= lowest_m && size.z * metres <= kHighest_m &&
               std::max(size.x, size.y) * metres <= kWidest_m;
    };
    // In metres a model may have any height below the limit: a yard, or a sheet.
    if (fits(1, 0)) return std::nullopt;
    constexpr std::array<LengthUnit, 3> kUnits{
        {{1e-3, "millimetres"}, {1e-2, "centimetres"}, {0.0254, "inches"}}};
    const auto* const unit = std::find_if(kUnits.begin(), kUnits.end(), [&](const LengthUnit& u) {
        return fits(u.metres, kLowest_m);
    });
    return unit == kUnits.end() ? std::nullopt : std::optional(*unit);
}

std::string size_text(const Vec3& size) {
    std::array<char, 64> line{};
    std::snprintf(line.data(), line.size(), "%.6g x %.6g x %.6g", double{size.x}, double{size.y},
                  double{size.z});
    return line.data();
}

}  // namespace aula
