#include "audio/render/early_filters.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace aula {

namespace {

/// Half of it, the largest error, is 0.3 % of the pressure: -51 dB of a path.
constexpr double kGainStep_db = 0.05;

/// Half of it changes the loss by air at 20 kHz, 0.5 dB/m, by 0.06 dB, within an octave by less.
constexpr double kLengthStep_m = 0.25;

/// Of the energy of a filter, which its last samples may have.
constexpr double kTail = 1e-8;

/// Gains below it are raised by the design.
constexpr double kLowest_db = -100;

constexpr double kDecibels = 20 / std::numbers::ln10;  ///< of a natural logarithm

}  // namespace

EarlyFilters::EarlyFilters(BandFilterDesigner& designer, bool has_air, std::size_t margin,
                           std::size_t sources)
    : designer_(designer),
      has_air_(has_air),
      margin_(margin),
      whole_(designer.taps()),
      used_(sources),
      before_(sources) {}

std::span<const float> EarlyFilters::filter(std::size_t source, const std::array<float, 8>& gains,
                                            double length_m) {
    const float greatest = *std::max_element(gains.begin(), gains.end());
    Key key;
    for (std::size_t b = 0; b < gains.size(); ++b) {
        // In double precision C libraries agree on logarithms. -inf without a gain.
        const double level_db = kDecibels * std::log(double{gains[b] / greatest});
        key[b] =
            static_cast<std::int16_t>(std::lround(std::max(kLowest_db, level_db) / kGainStep_db));
    }
    if (!has_air_) length_m = 0;
    // The design bounds the loss by air, which reaches the bound long before 8 km.
    key.back() = static_cast<std::int16_t>(std::lround(std::min(length_m, 8e3) / kLengthStep_m));
    Filters& used = used_[source];
    if (const auto found = used.find(key); found != used.end()) return found->second;
    if (auto kept = before_[source].extract(key))
        return used.insert(std::move(kept)).position->second;
    return used.try_emplace(key, design(key)).first->second;
}

AlignedVector<float> EarlyFilters::design(const Key& key) {
    std::array<float, 8> gains;
    for (std::size_t b = 0; b < gains.size(); ++b)
        gains[b] = static_cast<float>(std::exp(key[b] * kGainStep_db / kDecibels));
    designer_.design(gains, key.back() * kLengthStep_m, whole_);
    double energy = 0;
    for (const float x : whole_) energy += double{x} * double{x};
    double after = 0;
    std::size_t end = whole_.size();
    while (end > 1) {
        after += double{whole_[end - 1]} * double{whole_[end - 1]};
        if (after > kTail * energy) break;
        --end;
    }
    AlignedVector<float> filter(margin_ + end + margin_);
    std::copy_n(whole_.begin(), end, filter.begin() + static_cast<std::ptrdiff_t>(margin_));
    return filter;
}

void EarlyFilters::next_frame(std::size_t source) {
    before_[source] = std::move(used_[source]);
    used_[source].clear();
}

}  // namespace aula
