#include "engine/base/shifted_histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Number of floats of a value: 4 (FourVector) or 8 (BandVector).
template <typename Value>
constexpr std::size_t kFloats = sizeof(Value) / sizeof(float);

template <typename Value>
[[gnu::always_inline]] inline Value load(const float* from) {
    Value value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

template <typename Value>
[[gnu::always_inline]] inline void add(const Value& value, float* to) {
    const Value sum = load<Value>(to) + value;
    std::memcpy(to, &sum, sizeof sum);
}

constexpr std::size_t kPrefetchDistance = 32;  // bins

/// Adds consecutive bins to output bins of their width: each leaves the share `stays` in the output
/// bin of its number and the rest in the next.
template <typename Value>
class EqualBins {
 public:
    explicit EqualBins(float stays) : stays_(stays) {}

    [[gnu::always_inline]] void add(const Value& value, float* to) {
        const Value sum = load<Value>(to) + stays_ * value + passed_;
        std::memcpy(to, &sum, sizeof sum);
        passed_ = (1 - stays_) * value;
    }

    /// What the last bin leaves to the next.
    const Value& passed() const { return passed_; }

 private:
    float stays_;
    Value passed_{};
};

/// Adds a value that leaves the share `stays` in the output bin and the rest in the next.
template <typename Value>
[[gnu::always_inline]] inline void add_divided(const Value& value, float stays, float* out) {
    add<Value>(stays * value, out);
    add<Value>((1 - stays) * value, out + kFloats<Value>);
}

/// Adds bins [bin, end) of equal width until the output's width changes at out_end. The first
/// begins `x` output bins after the start of output bin `out`. An output bin is 1 / `ratio` times
/// as wide, `ratio` <= 1. `direction` multiplies the intensity, if given, or else the sum of the
/// weighted energy over bands. The part of a bin before the next output edge stays, the rest goes
/// to the next bin. Returns the bin after the last one added.
AULA_MULTIVERSION
std::size_t add_bins(const float* energy, const float* intensity, std::size_t bin, std::size_t end,
                     float ratio, const float* weight, const float* direction, float x,
                     std::size_t out, std::size_t out_end, float* out_energy,
                     float* out_intensity) {
    const auto weights = load<BandVector>(weight);
    const auto directions = load<FourVector>(direction);
    const auto energy_of = [&](std::size_t k) {
        return weights * load<BandVector>(energy + k * kBandCount);
    };
    const auto intensity_of = [&](std::size_t k) {
        return directions * load<FourVector>(intensity + k * 4);
    };
    if (ratio > 0.999F) {
        const std::size_t count = std::min(end - bin, out_end - out);
        out_energy += out * kBandCount;
        out_intensity += out * 4;
        EqualBins<BandVector> energies(1 - x);
        EqualBins<FourVector> intensities(1 - x);
        const auto add_all = [&](const auto& intensity_at) {
            for (std::size_t k = 0; k < count; ++k) {
                // Rows are scattered in memory.
                __builtin_prefetch(energy +
                                   std::min(bin + k + kPrefetchDistance, end) * kBandCount);
                const BandVector value = energy_of(bin + k);
                energies.add(value, out_energy + k * kBandCount);
                intensities.add(intensity_at(bin + k, value), out_intensity + k * 4);
            }
        };
        if (intensity) {
            add_all([&](std::size_t k, const BandVector&) { return intensity_of(k); });
        } else {
            add_all([&](std::size_t, const BandVector& value) {
                return directions * sum_of_bands(value)[0];
            });
        }
        add(energies.passed(), out_energy + count * kBandCount);
        add(intensities.passed(), out_intensity + count * 4);
        return bin + count;
    }
    for (; bin < end && out < out_end; ++bin) {
        const float stays = std::min(1.0F, (1 - x) / ratio);
        const BandVector value = energy_of(bin);
        add_divided<BandVector>(value, stays, out_energy + out * kBandCount);
        add_divided<FourVector>(intensity ? intensity_of(bin) : directions * sum_of_bands(value)[0],
                                stays, out_intensity + out * 4);
        x += ratio;
        if (x >= 1) {
            x -= 1;
            ++out;
        }
    }
    return bin;
}

}  // namespace

ShiftedHistogram::ShiftedHistogram(const TimeBins& bins)
    : bins_(bins), energy_((bins.count() + 1) * kBandCount), intensity_((bins.count() + 1) * 4) {
    for (std::size_t k = 0; k < bins.count(); ++k) {
        const auto width_s = static_cast<float>(bins.end_s(k) - bins.begin_s(k));
        if (regions_.empty() || std::abs(regions_.back().width_s - width_s) > 1e-6F) {
            regions_.push_back({k, k, width_s});
        }
        regions_.back().end_bin = k + 1;
    }
}

void ShiftedHistogram::add(const TimeHistogram& histogram, std::size_t first_bin,
                           std::size_t end_bin, double delay_s, const Bands& weight,
                           const Vec3& direction) {
    Vec3 factor = direction;
    if (histogram.intensity)
        factor = Vec3((weight * histogram.total).sum() / histogram.total.sum());
    const std::array<float, 4> factors{factor.x, factor.y, factor.z, 0};
    for (const Region& in : regions_) {
        std::size_t bin = std::max(first_bin, in.first_bin);
        const std::size_t end = std::min(end_bin, in.end_bin);
        while (bin < end) {
            const double begin_s = bins_.begin_s(bin) + delay_s;
            const std::size_t out = bins_.index(begin_s);
            if (out >= bins_.count()) return;
            const auto region = std::find_if(regions_.begin(), regions_.end(),
                                             [&](const Region& r) { return out < r.end_bin; });
            const auto x =
                static_cast<float>((begin_s - bins_.begin_s(out)) / double{region->width_s});
            bin = best_version<add_bins>(histogram.energy, histogram.intensity, bin, end,
                                         in.width_s / region->width_s, weight.value.data(),
                                         factors.data(), x, out, region->end_bin, energy_.data(),
                                         intensity_.data());
        }
    }
}

Bands ShiftedHistogram::energy(std::size_t bin) const {
    Bands energy;
    std::copy_n(&energy_[bin * kBandCount], kBandCount, energy.value.begin());
    return energy;
}

Vec3 ShiftedHistogram::intensity(std::size_t bin) const {
    return {intensity_[bin * 4], intensity_[bin * 4 + 1], intensity_[bin * 4 + 2]};
}

}  // namespace aula
