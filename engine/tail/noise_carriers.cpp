#include "engine/tail/noise_carriers.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "engine/base/fft.h"
#include "engine/base/sampling.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr double kLevelling = 8;  // window, independent samples of the carrier
constexpr float kSteps = 32767;   // of a carrier's peak

// The low carriers end at 1.6 kHz, the upper end of their last crossover; 8 taps per sample would
// leave an image of -56 dB, 12 leave -80 dB.
constexpr double kLowestRate_hz = 5500;

/// Low carriers have one sample of as many.
std::size_t decimation_of(double sample_rate_hz) {
    std::size_t decimation = 1;
    while (sample_rate_hz / static_cast<double>(2 * decimation) >= kLowestRate_hz) decimation *= 2;
    return decimation;
}

/// Uniform white noise of unit variance, identical on every machine.
std::vector<float> white_noise(std::size_t count, std::uint64_t seed) {
    RandomStream random(seed);
    std::vector<float> noise(count);
    for (float& x : noise) {
        x = static_cast<float>((static_cast<double>(random.bits() >> 11) * 0x1p-53 - 0.5) *
                               std::sqrt(12.0));
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

/// Amplitudes of a carrier in the bins from `first` on.
struct Weights {
    std::size_t first = 0;
    std::vector<float> weight;
};

/// Position in the crossover from the centre of a carrier to that of the next one: 0 below it, 1
/// above it.
class Crossover {
 public:
    explicit Crossover(std::size_t carrier)
        : begin_hz_(ThirdOctaveModel::centre_hz(carrier)),
          end_hz_(ThirdOctaveModel::centre_hz(carrier + 1)) {}

    double begin_hz() const { return begin_hz_; }
    double at(double frequency_hz) const {
        if (frequency_hz <= begin_hz_) return 0;
        if (frequency_hz >= end_hz_) return 1;
        return 10 * std::log10(frequency_hz / begin_hz_);
    }

 private:
    double begin_hz_, end_hz_;
};

/// The squares of the weights of all carriers sum to 1.
Weights weights_of(std::size_t carrier, std::size_t bins, double bin_hz) {
    const bool is_first = carrier == 0;
    const bool is_last = carrier + 1 == NoiseCarriers::kCount;
    const Crossover lower(is_first ? 0 : carrier - 1);
    const Crossover upper(carrier);
    Weights w;
    w.first = is_first ? 0 : static_cast<std::size_t>(lower.begin_hz() / bin_hz) + 1;
    for (std::size_t k = w.first; k < bins; ++k) {
        const double f_hz = static_cast<double>(k) * bin_hz;
        const double low = is_first ? 1 : lower.at(f_hz);
        const double high = is_last ? 0 : upper.at(f_hz);
        if (high == 1) break;
        w.weight.push_back(static_cast<float>(std::sin(std::numbers::pi / 2 * low) *
                                              std::cos(std::numbers::pi / 2 * high)));
    }
    return w;
}

/// FNV-1a.
std::uint64_t hash(std::string_view text) {
    std::uint64_t h = 0xcbf29ce484222325ULL;
    for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    return h;
}

/// Splits a periodic signal into third octaves.
class ThirdOctaveSplit {
 public:
    explicit ThirdOctaveSplit(const std::vector<float>& noise)
        : period_(noise.size()), real_(noise), imaginary_(noise.size()) {
        Fft(period_).forward(real_, imaginary_);
    }

    /// Two carriers, of one sample of `decimation` samples: the real and the imaginary part of one
    /// signal. Carriers with odd numbers are a quarter of a period ahead.
    void carriers(std::size_t first, const std::array<Weights, 2>& weights, std::size_t decimation,
                  Fft& fft, std::array<std::vector<float>, 2>& out) const {
        auto& [real, imaginary] = out;
        const std::size_t size = period_ / decimation;
        real.assign(size, 0);
        imaginary.assign(size, 0);
        const float scale = 1 / static_cast<float>(period_);
        for (std::size_t i = 0; i < 2; ++i) {
            const bool is_ahead = (first + i) % 2 == 1;
            for (std::size_t j = 0; j < weights[i].weight.size(); ++j) {
                const std::size_t k = weights[i].first + j;
                // The mean, and that at half of the rate, have no phase.
                if (k == 0 || 2 * k >= size) continue;
                const float weight = weights[i].weight[j] * scale;
                float x = weight * real_[k];
                float y = weight * imaginary_[k];
                if (is_ahead) x = -std::exchange(y, x);
                // The spectrum of a real signal, x - iy at -k; of i times one.
                real[k] += i == 0 ? x : -y;
                imaginary[k] += i == 0 ? y : x;
                real[size - k] += i == 0 ? x : y;
                imaginary[size - k] += i == 0 ? -y : x;
            }
        }
        fft.inverse(real, imaginary);
    }

 private:
    std::size_t period_;
    std::vector<float> real_, imaginary_;  ///< spectrum
};

}  // namespace

NoiseCarriers::NoiseCarriers(double sample_rate_hz, std::uint64_t seed)
    : NoiseCarriers(sample_rate_hz, seed,
                    white_noise(fast_period(sample_rate_hz,
                                            static_cast<std::size_t>(kPeriod_s * sample_rate_hz)),
                                derive_seed(seed, 0))) {}

NoiseCarriers::NoiseCarriers(double sample_rate_hz, const std::vector<float>& noise)
    : NoiseCarriers(sample_rate_hz, 0, noise) {}

NoiseCarriers::NoiseCarriers(double sample_rate_hz, std::uint64_t seed,
                             const std::vector<float>& noise)
    : sample_rate_hz_(sample_rate_hz),
      seed_(seed),
      period_samples_(noise.size()),
      decimation_(decimation_of(sample_rate_hz)) {
    assert(sample_rate_hz >= 8000);
    const ThirdOctaveSplit split(noise);
    const double bin_hz = sample_rate_hz / static_cast<double>(period_samples_);
    Fft low(period_samples_ / decimation_);
    Fft high(period_samples_);
    std::array<std::vector<float>, 2> pair;
    const std::size_t bins = period_samples_ / 2;
    for (std::size_t first = 0; first < kCount; first += first + 1 == kHigh ? 1 : 2) {
        const bool is_low = first < kHigh;
        const std::size_t count = std::min<std::size_t>(first + 2, is_low ? kHigh : kCount) - first;
        const std::array<Weights, 2> weights{
            weights_of(first, bins, bin_hz),
            count == 2 ? weights_of(first + 1, bins, bin_hz) : Weights{}};
        const std::size_t decimation = is_low ? decimation_ : 1;
        split.carriers(first, weights, decimation, is_low ? low : high, pair);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t k = first + i;
            double sum = 0;
            for (const float w : weights[i].weight) sum += double{w} * double{w};
            const double power = 2 * sum / static_cast<double>(period_samples_);
            power_[k] = static_cast<float>(power);
            std::vector<float>& carrier = pair[i];
            std::vector<std::int16_t>& whole = carriers_[k];
            whole.resize(carrier.size() + kMaxRead_samples);
            if (power == 0) continue;  // above half the sample rate
            // The bandwidth is the power times half the sample rate.
            level(carrier, power, 2 * kLevelling / power / static_cast<double>(decimation));
            float peak = 0;
            for (const float x : carrier) peak = std::max(peak, std::abs(x));
            step_[k] = peak / kSteps;
            best_version<quantise>(std::span<const float>(carrier), step_[k], whole.data());
            std::copy_n(whole.begin(), kMaxRead_samples,
                        whole.begin() + static_cast<std::ptrdiff_t>(carrier.size()));
        }
    }
}

std::size_t NoiseCarriers::fast_period(double sample_rate_hz, std::size_t least) {
    return Fft::fast_size(least, 2 * decimation_of(sample_rate_hz));
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
    const std::size_t start =
        (source_seed(seed_, source) % period_samples_ + apart) % period_samples_;
    return start / decimation_ * decimation_;
}

std::size_t NoiseCarriers::memory_bytes() const {
    std::size_t bytes = 0;
    for (const std::vector<std::int16_t>& carrier : carriers_)
        bytes += carrier.size() * sizeof(std::int16_t);
    return bytes;
}

}  // namespace aula
