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

constexpr Position position_of(std::size_t third) {
    const int thirds =
        std::clamp(static_cast<int>(third) - kOctave63, 0, 3 * static_cast<int>(kBandCount - 1));
    return {static_cast<std::size_t>(thirds / 3), static_cast<float>(thirds % 3) / 3};
}

constexpr std::array<Position, ThirdOctaveModel::kCount> positions() {
    std::array<Position, ThirdOctaveModel::kCount> all{};
    for (std::size_t t = 0; t < all.size(); ++t) all[t] = position_of(t);
    return all;
}

constexpr std::array<Position, ThirdOctaveModel::kCount> kPositions = positions();

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
    for (std::size_t t = 0; t < kCount; ++t) {
        const auto [below, share] = kPositions[t];
        double inside = double{octaves[below]};
        if (share > 0) inside += double{share} * (double{octaves[below + 1]} - inside);
        excess_per_m_[t] = static_cast<float>(air_attenuation_per_m(medium, centre_hz(t)) - inside);
    }
}

double ThirdOctaveModel::centre_hz(std::size_t third) {
    return 1000 * std::pow(10.0, (static_cast<double>(third) - 13) / 10);
}

std::size_t ThirdOctaveModel::octave(std::size_t third) {
    return std::min(third / 3, kBandCount - 1);
}

ThirdOctaveModel::Values ThirdOctaveModel::energies(const Bands& octaves, double length_m) const {
    std::array<float, kBandCount> level;  // base 2
    for (std::size_t b = 0; b < kBandCount; ++b) level[b] = std::log2(octaves[b]);
    const float nepers = -static_cast<float>(length_m * std::numbers::log2e);
    Values energies;
    for (std::size_t t = 0; t < kCount; ++t) {
        const auto [below, share] = kPositions[t];
        float x = level[below];
        if (share > 0) x = (1 - share) * x + share * level[below + 1];
        energies[t] = std::exp2(x + nepers * excess_per_m_[t]);
    }
    return energies;
}

}  // namespace aula
