#include "engine/base/shifted_histogram.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "engine/base/band_vector.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// Energies of a bin, [band], or its directions, [moment].
constexpr std::size_t kFloats = sizeof(BandVector) / sizeof(float);

[[gnu::always_inline]] inline void add(const BandVector& value, float* to) {
    store_bands(load_bands(to) + value, to);
}

constexpr std::size_t kPrefetchDistance = 32;  // bins

/// Adds consecutive bins to output bins of their width: each leaves the share `stays` in the output
/// bin of its number and the rest in the next.
class EqualBins {
 public:
    explicit EqualBins(float stays) : stays_(stays) {}

    [[gnu::always_inline]] void add(const BandVector& value, float* to) {
        store_bands(load_bands(to) + stays_ * value + passed_, to);
        passed_ = (1 - stays_) * value;
    }

    /// What the last bin leaves to the next.
    const BandVector& passed() const { return passed_; }

 private:
    float stays_;
    BandVector passed_{};
};

/// Adds a value that leaves the share `stays` in the output bin and the rest in the next.
[[gnu::always_inline]] inline void add_divided(const BandVector& value, float stays, float* out) {
    add(stays * value, out);
    add((1 - stays) * value, out + kFloats);
}

/// Adds bins [bin, end) of equal width until the output's width changes at out_end. The first
/// begins `x` output bins after the start of output bin `out`. An output bin is 1 / `ratio` times
/// as wide, `ratio` <= 1. `factors` multiply the directions, if given, or else the sum of the
/// weighted energy over bands. The part of a bin before the next output edge stays, the rest goes
/// to the next bin. Returns the bin after the last one added.
AULA_MULTIVERSION
std::size_t add_bins(const float* energy, const float* directions, std::size_t bin, std::size_t end,
                     float ratio, const float* weight, const float* factors, float x,
                     std::size_t out, std::size_t out_end, float* out_energy,
                     float* out_directions) {
    const BandVector weights = load_bands(weight);
    const BandVector moments = load_bands(factors);
    const auto energy_of = [&](std::size_t k) {
        return weights * load_bands(energy + k * kFloats);
    };
    const auto directions_of = [&](std::size_t k) {
        return moments * load_bands(directions + k * kFloats);
    };
    if (ratio > 0.999F) {
        const std::size_t count = std::min(end - bin, out_end - out);
        out_energy += out * kFloats;
        out_directions += out * kFloats;
        EqualBins energies(1 - x);
        EqualBins all_directions(1 - x);
        const auto add_all = [&](const auto& directions_at) {
            for (std::size_t k = 0; k < count; ++k) {
                // Rows are scattered in memory.
                __builtin_prefetch(energy + std::min(bin + k + kPrefetchDistance, end) * kFloats);
                const BandVector value = energy_of(bin + k);
                energies.add(value, out_energy + k * kFloats);
                all_directions.add(directions_at(bin + k, value), out_directions + k * kFloats);
            }
        };
        if (directions) {
            add_all([&](std::size_t k, const BandVector&) { return directions_of(k); });
        } else {
            add_all([&](std::size_t, const BandVector& value) {
                return moments * sum_of_bands(value);
            });
        }
        add(energies.passed(), out_energy + count * kFloats);
        add(all_directions.passed(), out_directions + count * kFloats);
        return bin + count;
    }
    for (; bin < end && out < out_end; ++bin) {
        const float stays = std::min(1.0F, (1 - x) / ratio);
        const BandVector value = energy_of(bin);
        add_divided(value, stays, out_energy + out * kFloats);
        add_divided(directions ? directions_of(bin) : moments * sum_of_bands(value), stays,
                    out_directions + out * kFloats);
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
    : bins_(bins),
      energy_((bins.count() + 1) * kFloats),
      directions_((bins.count() + 1) * kFloats) {
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
                           const DirectionMoments& directions) {
    Bands factors;
    if (histogram.directions) {
        factors = Bands::filled((weight * histogram.total).sum() / histogram.total.sum());
    } else {
        store_bands(load_moments(directions), factors.value.data());
    }
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
            bin = best_version<add_bins>(histogram.energy, histogram.directions, bin, end,
                                         in.width_s / region->width_s, weight.value.data(),
                                         factors.value.data(), x, out, region->end_bin,
                                         energy_.data(), directions_.data());
        }
    }
}

Bands ShiftedHistogram::energy(std::size_t bin) const {
    Bands energy;
    std::copy_n(&energy_[bin * kFloats], kFloats, energy.value.begin());
    return energy;
}

DirectionMoments ShiftedHistogram::directions(std::size_t bin) const {
    std::array<float, kFloats> moments;
    std::copy_n(&directions_[bin * kFloats], kFloats, moments.begin());
    return std::bit_cast<DirectionMoments>(moments);
}

}  // namespace aula
