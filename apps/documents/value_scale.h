#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "apps/documents/parameter_text.h"

namespace aula {

/// Red, green, blue: 0..1.
using Colour = glm::vec3;

/// Colour map of energies and of the parameters in maps: dark blue for 0 to bright yellow for 1.
Colour map_colour(float value);

/// Colour of cells of a map without a value.
inline constexpr Colour kNoValueColour{0.86F, 0.86F, 0.86F};

/// Round numbers at equal distances in a range, about `count` of them; `min` for an empty range.
std::vector<double> round_numbers(double min, double max, int count);

/// The number of decimals that tell round numbers apart.
int decimals_of(const std::vector<double>& numbers);

/// The range of values that a map's colours show.
struct ValueScale {
    double min = 0;
    double max = 1;

    /// The colour of a value; values outside have that of the nearest end.
    Colour colour(double value) const {
        return map_colour(static_cast<float>((value - min) / (max - min)));
    }
};

/// The range of the values of a parameter, at least two just noticeable differences wide, so that
/// differences that nobody hears have like colours.
ValueScale value_scale(std::span<const std::optional<double>> values, const ParameterText& text);

}  // namespace aula
