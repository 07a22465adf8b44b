#include "apps/documents/value_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

namespace aula {

Colour map_colour(float value) {
    static constexpr std::array<Colour, 6> kMap{{
        {0.05F, 0.05F, 0.20F},
        {0.24F, 0.07F, 0.45F},
        {0.60F, 0.15F, 0.45F},
        {0.90F, 0.35F, 0.20F},
        {0.98F, 0.65F, 0.15F},
        {1.00F, 0.95F, 0.55F},
    }};
    const float index = std::clamp(value, 0.0F, 1.0F) * static_cast<float>(kMap.size() - 1);
    const auto low = std::min(static_cast<std::size_t>(index), kMap.size() - 2);
    return glm::mix(kMap[low], kMap[low + 1], index - static_cast<float>(low));
}

std::vector<double> round_numbers(double min, double max, int count) {
    if (!(max > min)) return {min};
    const double rough = (max - min) / count;
    const double decade = std::pow(10, std::floor(std::log10(rough)));
    double step = 10 * decade;
    for (const double factor : {5.0, 2.0, 1.0})
        if (factor * decade >= rough * 0.999) step = factor * decade;
    std::vector<double> numbers;
    const double slack = 1e-6;
    for (double i = std::ceil(min / step - slack); i <= max / step + slack; ++i)
        numbers.push_back(i * step);
    return numbers;
}

int decimals_of(const std::vector<double>& numbers) {
    if (numbers.size() < 2) return 2;
    return std::max(0, static_cast<int>(std::ceil(-std::log10(numbers[1] - numbers[0]) - 1e-6)));
}

ValueScale value_scale(std::span<const std::optional<double>> values, const ParameterText& text) {
    std::optional<ValueScale> range;
    for (const std::optional<double>& value : values) {
        if (!value) continue;
        if (!range) range = ValueScale{*value, *value};
        range->min = std::min(range->min, *value);
        range->max = std::max(range->max, *value);
    }
    if (!range) return {};
    const double middle = (range->min + range->max) / 2;
    const double noticeable = text.noticeable * (text.is_share ? std::abs(middle) : 1);
    const double half = std::max({(range->max - range->min) / 2, noticeable, 1e-6});
    return {middle - half, middle + half};
}

}  // namespace aula
