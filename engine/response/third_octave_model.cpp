#include "engine/response/third_octave_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "aula/engine/third_octaves.h"
#include "engine/scene/air.h"

namespace aula {
namespace {

constexpr int kOctave63 = 1;  // the third octave with the centre of the lowest octave

/// Position between the centres of two octaves.
struct Position {
    std::size_t below;
    float share;  ///< of the octave above
};

/// Of a point of the model: the third octave n has its centre at the point 2 n + 1.
constexpr Position position_of(std::size_t point) {
    const int sixths = std::clamp(static_cast<int>(point) - 1 - 2 * kOctave63, 0,
                                  6 * static_cast<int>(kBandCount - 1));
    return {static_cast<std::size_t>(sixths / 6), static_cast<float>(sixths % 6) / 6};
}

constexpr auto kPositions = [] {
    std::array<Position, 2 * ThirdOctaveModel::kCount + 1> all{};
    for (std::size_t p = 0; p < all.size(); ++p) all[p] = position_of(p);
    return all;
}();

double frequency_hz(std::size_t point) {
    return 1000 * std::pow(10.0, (static_cast<double>(point) - 27) / 20);
}

Bands levels_of(const Bands& octaves) {
    Bands levels;  // base 2
    for (std::size_t b = 0; b < kBandCount; ++b)
        levels[b] = static_cast<float>(std::log2(double{octaves[b]}));
    return levels;
}

/// The mean over a band of an energy whose level, base 2, rises linearly by `rise` and has the
/// value `centre` in its middle: 2^centre sinh(x) / x, x = rise ln(2) / 2.
float mean_energy(double centre, double rise) {
    // Below this rise the value at the centre is the mean to 2e-10 (x^2 / 6), and the difference
    // would lose five of 16 digits. Beside silence the rise is not finite.
    constexpr double kSmall = 1e-4;
    const bool is_level = !std::isfinite(rise) || std::abs(rise) < kSmall;
    return static_cast<float>(is_level
                                  ? std::exp2(centre)
                                  : (std::exp2(centre + rise / 2) - std::exp2(centre - rise / 2)) /
                                        (rise * std::numbers::ln2));
}

}  // namespace

const char* third_octave_name(std::size_t third) {
    static constexpr std::array<const char*, kThirdOctaveCount> kNames{
        "50",   "63",   "80",   "100",  "125",  "160",   "200",   "250",  "315",
        "400",  "500",  "630",  "800",  "1000", "1250",  "1600",  "2000", "2500",
        "3150", "4000", "5000", "6300", "8000", "10000", "12500", "16000"};
    return kNames[third];
}

ThirdOctaveModel::ThirdOctaveModel(const Medium& medium) {
    const Bands octaves = medium.attenuation_per_m();
    for (std::size_t p = 0; p < kPoints; ++p) {
        const auto [below, share] = kPositions[p];
        double inside = double{octaves[below]};
        if (share > 0) inside += double{share} * (double{octaves[below + 1]} - inside);
        excess_per_m_[p] =
            static_cast<float>(air_attenuation_per_m(medium, frequency_hz(p)) - inside);
    }
}

double ThirdOctaveModel::centre_hz(std::size_t third) {
    return 1000 * std::pow(10.0, (static_cast<double>(third) - 13) / 10);
}

std::size_t ThirdOctaveModel::octave(std::size_t third) {
    return std::min(third / 3, kBandCount - 1);
}

/// The level of a point, base 2.
float ThirdOctaveModel::level(const Bands& octave_levels, double length_m,
                              std::size_t point) const {
    const auto [below, share] = kPositions[point];
    float x = octave_levels[below];
    if (share > 0) x = (1 - share) * x + share * octave_levels[below + 1];
    const float nepers = -static_cast<float>(length_m * std::numbers::log2e);
    return x + nepers * excess_per_m_[point];
}

ThirdOctaveModel::Values ThirdOctaveModel::at_centres(const Bands& octaves, double length_m) const {
    const Bands levels = levels_of(octaves);
    Values energies;
    for (std::size_t t = 0; t < kCount; ++t)
        energies[t] = static_cast<float>(std::exp2(double{level(levels, length_m, 2 * t + 1)}));
    return energies;
}

ThirdOctaveModel::Values ThirdOctaveModel::energies(const Bands& octaves, double length_m) const {
    const Bands levels = levels_of(octaves);
    Values energies;
    float lower = level(levels, length_m, 0);
    for (std::size_t t = 0; t < kCount; ++t) {
        const float upper = level(levels, length_m, 2 * t + 2);
        energies[t] = mean_energy(level(levels, length_m, 2 * t + 1), upper - lower);
        lower = upper;
    }
    return energies;
}

}  // namespace aula
