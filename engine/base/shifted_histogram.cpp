#include "engine/base/shifted_histogram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "engine/base/band_vector.h"
#include "engine/base/multiversion.h"

namespace aula {

namespace {

/// Number of floats of a value: 1, 4 (FourVector) or 8 (BandVector).
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

/// Adds `count` bins of the output's width times `weight`: each leaves the share `stays` in the
/// output bin of its number and the rest in the next.
template <typename In, typename Out>
[[gnu::always_inline]] inline void add_equal_bins(const float* in, std::size_t count, float stays,
                                                  const Out& weight, float* out) {
    const Out keep = stays * weight;
    const Out pass = (1 - stays) * weight;
    Out passed{};
    for (std::size_t k = 0; k < count; ++k) {
        const In here = load<In>(in + k * kFloats<In>);
        const Out sum = load<Out>(out + k * kFloats<Out>) + keep * here + passed;
        std::memcpy(out + k * kFloats<Out>, &sum, sizeof sum);
        passed = pass * here;
    }
    add(passed, out + count * kFloats<Out>);
}

/// Adds a value that leaves the share `stays` in the output bin and the rest in the next.
template <typename Value>
[[gnu::always_inline]] inline void add_divided(const Value& value, float stays, float* out) {
    add<Value>(stays * value, out);
    add<Value>((1 - stays) * value, out + kFloats<Value>);
}

/// Adds bins [bin, end) of equal width until the output's width changes at out_end. The first
/// begins `x` output bins after the start of output bin `out`. An output bin is 1 / `ratio` times
/// as wide, `ratio` <= 1. `direction` multiplies the intensity, if given, or else the sums. The
/// part of a bin before the next output edge stays, the rest goes to the next bin. Returns the bin
/// after the last one added.
AULA_MULTIVERSION
std::size_t add_bins(const float* energy, const float* sum, const float* intensity, std::size_t bin,
                     std::size_t end, float ratio, const float* weight, const float* direction,
                     float x, std::size_t out, std::size_t out_end, float* out_energy,
                     float* out_intensity) {
    const auto weights = load<BandVector>(weight);
    const auto directions = load<FourVector>(direction);
    if (ratio > 0.999F) {
        const std::size_t count = std::min(end - bin, out_end - out);
        const float stays = 1 - x;
        add_equal_bins<BandVector>(energy + bin * kBandCount, count, stays, weights,
                                   out_energy + out * kBandCount);
        if (intensity) {
            add_equal_bins<FourVector>(intensity + bin * 4, count, stays, directions,
                                       out_intensity + out * 4);
        } else {
            add_equal_bins<float>(sum + bin, count, stays, directions, out_intensity + out * 4);
        }
        return bin + count;
    }
    for (; bin < end && out < out_end; ++bin) {
        const float stays = std::min(1.0F, (1 - x) / ratio);
        add_divided<BandVector>(weights * load<BandVector>(energy + bin * kBandCount), stays,
                                out_energy + out * kBandCount);
        add_divided<FourVector>(
            intensity ? directions * load<FourVector>(intensity + bin * 4) : directions * sum[bin],
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
    float weighted = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) weighted += weight[b] * histogram.total[b];
    const float mean_weight = weighted / histogram.total.sum();
    const bool directed = !histogram.intensity.empty();
    const Vec3 mean = directed ? Vec3(mean_weight) : direction * mean_weight;
    const std::array<float, 4> factors{mean.x, mean.y, mean.z, 0};
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
            bin = add_bins(histogram.energy.data(), histogram.sum.data(),
                           directed ? histogram.intensity.data() : nullptr, bin, end,
                           in.width_s / region->width_s, weight.value.data(), factors.data(), x,
                           out, region->end_bin, energy_.data(), intensity_.data());
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
