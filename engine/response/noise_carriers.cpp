#include "engine/response/noise_carriers.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <span>

#include "engine/base/sampling.h"
#include "engine/response/octave_bank.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr double kDecay_s = 0.5;              // duration of the lowest octave filter's response
constexpr double kLevelling = 8;              // window, independent samples of the band
constexpr float kSteps = 32767;               // of a carrier's peak
constexpr std::size_t kBlock_samples = 1024;  // of the filters, in the cache

/// Uniform white noise of unit variance, identical on every machine.
std::vector<double> white_noise(std::size_t count, std::uint64_t seed) {
    RandomStream random(seed);
    std::vector<double> noise(count);
    for (double& x : noise) {
        x = (static_cast<double>(random.bits() >> 11) * 0x1p-53 - 0.5) * std::sqrt(12.0);
    }
    return noise;
}

/// Levels samples to a power. The window of sample n has the energies from sums[n] to
/// sums[n + window], which are cumulative.
AULA_MULTIVERSION
void level_part(std::span<float> samples, const double* sums, std::size_t window, double power) {
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double mean = (sums[n + window] - sums[n]) / static_cast<double>(window);
        samples[n] *= static_cast<float>(mean > 0 ? std::sqrt(power / mean) : 1);
    }
}

/// Rounds to multiples of `step`, halves away from 0.
AULA_MULTIVERSION
void quantise(std::span<const float> samples, float step, std::int16_t* to) {
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double x{samples[n] / step};
        to[n] = static_cast<std::int16_t>(static_cast<int>(x + std::copysign(0.5, x)));
    }
}

/// Scales a periodic carrier such that its power over a sliding window is constant. This preserves
/// the slope of a decay: the standard deviation of T30 at 1 kHz falls from 2.5 % to 0.7 %. The
/// window is long enough to preserve the spectrum of the noise.
void level(std::vector<float>& carrier, double power, double window_samples) {
    const std::size_t period = carrier.size();
    const auto half =
        static_cast<std::size_t>(std::min(window_samples, static_cast<double>(period - 1)) / 2);
    std::vector<double> energy(2 * period + 1);  // cumulative, over two periods
    for (std::size_t n = 0; n < 2 * period; ++n) {
        const double x{carrier[n < period ? n : n - period]};
        energy[n + 1] = energy[n] + x * x;
    }
    // Windows that begin before the first sample are those of the second period.
    best_version<level_part>(std::span(carrier).first(half), energy.data() + period - half,
                             2 * half + 1, power);
    best_version<level_part>(std::span(carrier).subspan(half), energy.data(), 2 * half + 1, power);
}

/// FNV-1a.
std::uint64_t hash(std::string_view text) {
    std::uint64_t h = 0xcbf29ce484222325ULL;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return h;
}

}  // namespace

NoiseCarriers::NoiseCarriers(double sample_rate_hz, std::uint64_t seed)
    : NoiseCarriers(
          sample_rate_hz, seed,
          white_noise(static_cast<std::size_t>(kPeriod_s * sample_rate_hz), derive_seed(seed, 0))) {
}

NoiseCarriers::NoiseCarriers(double sample_rate_hz, const std::vector<double>& noise)
    : NoiseCarriers(sample_rate_hz, 0, noise) {}

NoiseCarriers::NoiseCarriers(double sample_rate_hz, std::uint64_t seed,
                             const std::vector<double>& noise)
    : sample_rate_hz_(sample_rate_hz), seed_(seed), period_samples_(noise.size()) {
    assert(sample_rate_hz >= 8000);
    assert(static_cast<double>(noise.size()) >= kDecay_s * sample_rate_hz);
    const auto decay = static_cast<std::size_t>(kDecay_s * sample_rate_hz);
    std::vector<double> impulse(2 * decay);
    impulse[0] = 1;
    std::array<double, kBandCount> power{};
    for (const auto& h : OctaveBank(sample_rate_hz).process(impulse)) {
        for (std::size_t b = 0; b < kBandCount; ++b) power[b] += h[b] * h[b];
    }

    // The response of the bank to a periodic sequence is periodic after the transient.
    std::array<std::vector<float>, kBandCount> carriers;
    for (auto& carrier : carriers) carrier.resize(period_samples_);
    OctaveBank bank(sample_rate_hz);
    bank.process(std::span(noise).last(decay));
    for (std::size_t first = 0; first < period_samples_; first += kBlock_samples) {
        const std::size_t count = std::min(kBlock_samples, period_samples_ - first);
        const auto bands = bank.process(std::span(noise).subspan(first, count));
        for (std::size_t n = 0; n < count; ++n) {
            for (std::size_t b = 0; b < kBandCount; ++b)
                carriers[b][first + n] = static_cast<float>(bands[n][b]);
        }
    }

    for (std::size_t b = 0; b < kBandCount; ++b) {
        power_[b] = static_cast<float>(power[b]);
        std::vector<std::int16_t>& whole = carriers_[b];
        whole.resize(period_samples_ + kMaxRead_samples);
        if (power[b] == 0) continue;  // above half the sample rate
        // The bandwidth is power[b] times half the sample rate.
        level(carriers[b], power[b], 2 * kLevelling / power[b]);
        float peak = 0;
        for (const float x : carriers[b]) peak = std::max(peak, std::abs(x));
        step_[b] = peak / kSteps;
        best_version<quantise>(carriers[b], step_[b], whole.data());
        std::copy_n(whole.begin(), kMaxRead_samples,
                    whole.begin() + static_cast<std::ptrdiff_t>(period_samples_));
    }
}

std::uint64_t NoiseCarriers::source_seed(std::uint64_t seed, std::string_view source) {
    return derive_seed(seed, 1, hash(source));
}

std::size_t NoiseCarriers::offset(std::string_view source, std::size_t channel) const {
    assert(channel < kMaxChannels);
    // The channels of a source are spaced evenly over the period, those of low orders farthest
    // apart.
    constexpr std::size_t kStride = 7;  // has no factor in common with kMaxChannels
    const std::size_t apart = channel * kStride % kMaxChannels * period_samples_ / kMaxChannels;
    return (source_seed(seed_, source) % period_samples_ + apart) % period_samples_;
}

std::size_t NoiseCarriers::memory_bytes() const {
    return kBandCount * (period_samples_ + kMaxRead_samples) * sizeof(std::int16_t);
}

}  // namespace aula
