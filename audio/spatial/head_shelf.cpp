#include "audio/spatial/head_shelf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace aula {

namespace {

// Least-squares fits of shelves, from 100 Hz to 10 kHz, to the pressure on a rigid sphere of 8.75
// cm for a point source (Duda and Martens 1998, "Range dependence of the response of a spherical
// head model", eq. 1) over that for a plane wave. Within 1.5 dB of it (test_audio "The shelves of a
// near source*").
constexpr std::array<float, 8> kDistances_m{0.12F, 0.14F, 0.17F, 0.2F, 0.25F, 0.35F, 0.6F, 1.2F};
constexpr std::array<float, 11> kAngles_deg{0, 15, 30, 45, 60, 75, 90, 110, 130, 150, 180};

using Table = std::array<std::array<float, kAngles_deg.size()>, kDistances_m.size()>;

constexpr Table kLow_db{{
    {15.3F, 12.5F, 8.0F, 4.1F, 0.9F, -1.5F, -3.4F, -5.3F, -6.6F, -7.4F, -7.9F},
    {11.9F, 10.4F, 7.3F, 4.2F, 1.4F, -0.9F, -2.6F, -4.4F, -5.7F, -6.5F, -6.9F},
    {9.0F, 8.2F, 6.2F, 3.9F, 1.7F, -0.3F, -1.9F, -3.5F, -4.6F, -5.4F, -5.8F},
    {7.3F, 6.7F, 5.4F, 3.6F, 1.8F, 0.1F, -1.4F, -2.9F, -3.9F, -4.6F, -5.0F},
    {5.6F, 5.2F, 4.3F, 3.1F, 1.7F, 0.3F, -0.9F, -2.2F, -3.1F, -3.8F, -4.1F},
    {3.8F, 3.6F, 3.1F, 2.3F, 1.4F, 0.4F, -0.5F, -1.5F, -2.2F, -2.7F, -3.0F},
    {2.1F, 2.0F, 1.8F, 1.4F, 0.9F, 0.4F, -0.2F, -0.8F, -1.3F, -1.6F, -1.8F},
    {1.0F, 1.0F, 0.9F, 0.7F, 0.5F, 0.2F, 0.0F, -0.4F, -0.6F, -0.8F, -0.9F},
}};

constexpr Table kHigh_db{{
    {11.1F, 8.6F, 4.4F, 0.5F, -3.4F, -7.1F, -10.1F, -12.5F, -13.3F, -13.7F, -13.9F},
    {8.3F, 7.0F, 4.2F, 1.1F, -2.0F, -5.3F, -8.1F, -10.4F, -11.2F, -11.6F, -11.8F},
    {6.1F, 5.4F, 3.7F, 1.5F, -1.0F, -3.7F, -6.1F, -8.3F, -9.1F, -9.4F, -9.7F},
    {4.9F, 4.4F, 3.2F, 1.5F, -0.5F, -2.7F, -4.9F, -6.9F, -7.7F, -8.0F, -8.2F},
    {3.6F, 3.3F, 2.5F, 1.4F, -0.1F, -1.8F, -3.6F, -5.4F, -6.2F, -6.4F, -6.6F},
    {2.4F, 2.3F, 1.8F, 1.1F, 0.1F, -1.0F, -2.4F, -3.8F, -4.4F, -4.6F, -4.8F},
    {1.3F, 1.2F, 1.0F, 0.7F, 0.2F, -0.5F, -1.2F, -2.1F, -2.6F, -2.7F, -2.8F},
    {0.6F, 0.6F, 0.5F, 0.3F, 0.1F, -0.2F, -0.6F, -1.0F, -1.3F, -1.4F, -1.4F},
}};

constexpr Table kCorner_hz{{
    {390, 400, 450, 630, 1040, 1570, 1950, 2260, 2620, 3190, 3740},
    {380, 380, 420, 550, 880, 1450, 1920, 2310, 2710, 3370, 4050},
    {370, 370, 400, 490, 750, 1300, 1890, 2380, 2830, 3580, 4440},
    {360, 360, 380, 470, 690, 1200, 1850, 2430, 2910, 3740, 4750},
    {350, 350, 370, 440, 630, 1090, 1790, 2480, 3020, 3930, 5130},
    {340, 350, 370, 420, 580, 970, 1700, 2540, 3130, 4150, 5630},
    {340, 340, 360, 410, 540, 880, 1580, 2570, 3260, 4390, 6220},
    {330, 340, 350, 400, 520, 820, 1480, 2580, 3350, 4560, 6690},
}};

/// A place in a table, linear in between.
struct Place {
    std::size_t index;  ///< of the node before
    float share;        ///< of the node after
};

/// The place among the inverse distances, which end at 0: there the gains are 0 dB.
Place place_of_distance(float distance_m) noexcept {
    std::size_t i = 0;
    while (i + 1 < kDistances_m.size() && distance_m > kDistances_m[i + 1]) ++i;
    const float from = 1 / kDistances_m[i];
    const float to = i + 1 < kDistances_m.size() ? 1 / kDistances_m[i + 1] : 0;
    return {i, std::max(0.0F, (from - 1 / std::max(distance_m, kDistances_m[0])) / (from - to))};
}

Place place_of_angle(float cosine) noexcept {
    const auto angle_deg = static_cast<float>(std::acos(std::clamp(double{cosine}, -1.0, 1.0)) *
                                              180 / std::numbers::pi);
    std::size_t i = 0;
    while (i + 2 < kAngles_deg.size() && angle_deg > kAngles_deg[i + 1]) ++i;
    return {i, (angle_deg - kAngles_deg[i]) / (kAngles_deg[i + 1] - kAngles_deg[i])};
}

/// `beyond`: the share of the last row that is left at an infinite distance.
float look_up(const Table& table, const Place& distance, const Place& angle,
              float beyond) noexcept {
    const auto at = [&](std::size_t row) {
        const auto& values = table[std::min(row, table.size() - 1)];
        const float value =
            values[angle.index] + angle.share * (values[angle.index + 1] - values[angle.index]);
        return row < table.size() ? value : beyond * value;
    };
    const float near = at(distance.index);
    return near + distance.share * (at(distance.index + 1) - near);
}

float gain_of(float level_db) noexcept {
    return static_cast<float>(std::pow(10, double{level_db} / 20));
}

}  // namespace

HeadShelf HeadShelf::at(float distance_m, float reference_m, float cosine) noexcept {
    const Place distance = place_of_distance(std::min(distance_m, reference_m));
    const Place reference = place_of_distance(reference_m);
    const Place angle = place_of_angle(cosine);
    return {look_up(kLow_db, distance, angle, 0) - look_up(kLow_db, reference, angle, 0),
            look_up(kHigh_db, distance, angle, 0) - look_up(kHigh_db, reference, angle, 0),
            look_up(kCorner_hz, distance, angle, 1)};
}

// H(s) = (low + high s / w) / (1 + s / w), by the bilinear transform that is exact at the corner.
void HeadShelf::apply(double sample_rate_hz, std::span<float> response) const noexcept {
    const float low = gain_of(low_db);
    const float high = gain_of(high_db);
    const auto w = static_cast<float>(
        std::tan(std::numbers::pi * std::min(double{corner_hz} / sample_rate_hz, 0.45)));
    const float b0 = (low * w + high) / (w + 1);
    const float b1 = (low * w - high) / (w + 1);
    const float a1 = (w - 1) / (w + 1);
    float in = 0;
    float out = 0;
    for (float& x : response) {
        out = b0 * x + b1 * in - a1 * out;
        in = x;
        x = out;
    }
}

}  // namespace aula
