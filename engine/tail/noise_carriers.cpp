#include "engine/tail/noise_carriers.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>
#include <utility>

#include "engine/base/fft.h"
#include "engine/base/sampling.h"
#include "process/multiversion.h"

namespace aula {
namespace {

constexpr double kLevelling = 64;  // window, independent samples of the carrier
constexpr float kSteps = 32767;    // of a carrier's peak

// The low carriers end at 2 kHz, the upper end of their last crossover; 12 taps per sample would
// leave an image of -63 dB, 16 leave -79 dB.
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
    const auto wanted = static_cast<float>(power * static_cast<double>(window));
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const auto energy = static_cast<float>(sums[n + window] - sums[n]);
        samples[n] *= energy > 0 ? std::sqrt(wanted / energy) : 1.0F;
    }
}

/// The largest magnitude.
AULA_MULTIVERSION
void find_peak(std::span<const float> samples, float& peak) {
    using Together = float __attribute__((vector_size(16 * sizeof(float))));
    Together most{}, least{};
    std::size_t n = 0;
    for (; n + 16 <= samples.size(); n += 16) {
        Together x;
        std::memcpy(&x, samples.data() + n, sizeof x);
        most = most < x ? x : most;
        least = least > x ? x : least;
    }
    peak = 0;
    for (; n < samples.size(); ++n) peak = std::max(peak, std::abs(samples[n]));
    for (std::size_t k = 0; k < 16; ++k) peak = std::max({peak, most[k], -least[k]});
}

/// Rounds to multiples of `step`, halves away from 0.
AULA_MULTIVERSION
void quantise(std::span<const float> samples, float step, std::int16_t* to) {
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double x{samples[n] / step};
        to[n] = static_cast<std::int16_t>(static_cast<int>(x + std::copysign(0.5, x)));
    }
}

/// The sums of the squares of the first n samples, for n from 0 on. Parts are added up at the same
/// time: an addition does not wait for the one before.
void add_up(std::span<const float> samples, double* sums) {
    constexpr std::size_t kParts = 8;  // more than the cycles of an addition
    const std::size_t part = samples.size() / kParts;
    std::array<double, kParts> sum{};
    for (std::size_t n = 0; n < part; ++n) {
        for (std::size_t k = 0; k < kParts; ++k) {
            const double x{samples[k * part + n]};
            sum[k] += x * x;
            sums[k * part + n + 1] = sum[k];
        }
    }
    sums[0] = 0;
    for (std::size_t k = 1; k < kParts; ++k)
        for (std::size_t n = 1; n <= part; ++n) sums[k * part + n] += sums[k * part];
    for (std::size_t n = kParts * part; n < samples.size(); ++n) {
        const double x{samples[n]};
        sums[n + 1] = sums[n] + x * x;
    }
}

/// Scales a periodic carrier such that its power over a sliding window is constant. This preserves
/// the slope of a decay: the standard deviation of T30 at 1 kHz falls from 2.5 % to 0.7 %. The
/// window is long enough to preserve the spectrum of the noise. `energy` is work space.
void level(std::vector<float>& carrier, double power, double window_samples,
           std::vector<double>& energy) {
    const std::size_t period = carrier.size();
    const auto half =
        static_cast<std::size_t>(std::min(window_samples, static_cast<double>(period - 1)) / 2);
    energy.resize(2 * period + 1);  // cumulative, over two periods
    add_up(carrier, energy.data());
    for (std::size_t n = 1; n <= period; ++n) energy[period + n] = energy[period] + energy[n];
    // Windows that begin before the first sample are those of the second period.
    best_version<level_part>(std::span(carrier).first(half), energy.data() + period - half,
                             2 * half + 1, power);
    best_version<level_part>(std::span(carrier).subspan(half), energy.data(), 2 * half + 1, power);
}

using Weights = CarrierFilters::Weights;

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
    ThirdOctaveSplit(const std::vector<float>& noise, Fft fft)
        : period_(noise.size()), real_(noise), imaginary_(noise.size()) {
        fft.forward(real_, imaginary_);
    }

    /// Calls `each(carrier, samples)` for the carriers from `first` to `end`, of fft.size()
    /// samples. Two of them are the real and the imaginary part of one signal. Carriers with odd
    /// numbers are a quarter of a period ahead. Those without a weight, the last ones, are omitted.
    template <typename Each>
    void carriers(std::size_t first, std::size_t end, std::span<const Weights> weights, Fft& fft,
                  const Each& each) const {
        while (end > first && weights[end - 1].weight.empty()) --end;
        const std::size_t together =
            std::clamp<std::size_t>(kTogether_samples / fft.size(), 1, kMostTogether);
        std::vector<float> real, imaginary, carrier(fft.size());
        for (; first < end; first += 2 * together) {
            const std::size_t count = std::min(2 * together, end - first);
            const std::size_t signals = (count + 1) / 2;
            real.assign(fft.size() * signals, 0);
            imaginary.assign(fft.size() * signals, 0);
            for (std::size_t i = 0; i < count; ++i)
                add(first + i, weights[first + i], fft.size(), i, signals, real, imaginary);
            fft.inverse(real, imaginary);
            for (std::size_t i = 0; i < count; ++i) {
                const std::vector<float>& from = i % 2 == 0 ? real : imaginary;
                for (std::size_t n = 0; n < carrier.size(); ++n)
                    carrier[n] = from[n * signals + i / 2];
                each(first + i, carrier);
            }
        }
    }

 private:
    /// Signals that are transformed together: fewer wait for memory, more leave the cache.
    static constexpr std::size_t kTogether_samples = 1 << 17;
    static constexpr std::size_t kMostTogether = 4;

    /// Adds the spectrum of carrier k to part i % 2 of the signal i / 2 of `signals`.
    void add(std::size_t k, const Weights& weights, std::size_t size, std::size_t i,
             std::size_t signals, std::vector<float>& real, std::vector<float>& imaginary) const {
        const float scale = 1 / static_cast<float>(period_);
        const bool is_ahead = k % 2 == 1;
        for (std::size_t j = 0; j < weights.weight.size(); ++j) {
            const std::size_t bin = weights.first + j;
            // The mean, and that at half of the rate, have no phase.
            if (bin == 0 || 2 * bin >= size) continue;
            const float weight = weights.weight[j] * scale;
            float x = weight * real_[bin];
            float y = weight * imaginary_[bin];
            if (is_ahead) x = -std::exchange(y, x);
            // The spectrum of a real signal, x - iy at -bin; of i times one.
            const std::size_t at = bin * signals + i / 2;
            const std::size_t opposite = (size - bin) * signals + i / 2;
            real[at] += i % 2 == 0 ? x : -y;
            imaginary[at] += i % 2 == 0 ? y : x;
            real[opposite] += i % 2 == 0 ? x : y;
            imaginary[opposite] += i % 2 == 0 ? -y : x;
        }
    }

    std::size_t period_;
    std::vector<float> real_, imaginary_;  ///< spectrum
};

}  // namespace

CarrierFilters::CarrierFilters(double sample_rate_hz, std::size_t period_samples)
    : sample_rate_hz_(sample_rate_hz),
      low_(period_samples / decimation_of(sample_rate_hz)),
      high_(period_samples) {
    assert(sample_rate_hz >= 8000);
    const double bin_hz = sample_rate_hz / static_cast<double>(period_samples);
    for (std::size_t k = 0; k < weights_.size(); ++k)
        weights_[k] = weights_of(k, period_samples / 2, bin_hz);
}

NoiseCarriers::NoiseCarriers(double sample_rate_hz, std::uint64_t seed)
    : NoiseCarriers(
          CarrierFilters(
              sample_rate_hz,
              fast_period(sample_rate_hz, static_cast<std::size_t>(kPeriod_s * sample_rate_hz))),
          seed,
          white_noise(
              fast_period(sample_rate_hz, static_cast<std::size_t>(kPeriod_s * sample_rate_hz)),
              derive_seed(seed, 0))) {}

NoiseCarriers::NoiseCarriers(const CarrierFilters& filters, const std::vector<float>& noise)
    : NoiseCarriers(filters, 0, noise) {}

NoiseCarriers::NoiseCarriers(const CarrierFilters& filters, std::uint64_t seed,
                             const std::vector<float>& noise)
    : sample_rate_hz_(filters.sample_rate_hz()),
      seed_(seed),
      period_samples_(filters.period_samples()),
      decimation_(filters.decimation()) {
    assert(noise.size() == period_samples_);
    Fft low = filters.low();
    Fft high = filters.high();
    const ThirdOctaveSplit split(noise, high);
    for (std::size_t k = 0; k < kCount; ++k)
        carriers_[k].resize((k < kHigh ? low : high).size() + kMaxRead_samples);
    std::vector<double> energy;
    const auto keep = [&](std::size_t k, std::vector<float>& carrier) {
        double sum = 0;
        for (const float w : filters.weights()[k].weight) sum += double{w} * double{w};
        const double power = 2 * sum / static_cast<double>(period_samples_);
        power_[k] = static_cast<float>(power);
        if (power == 0) return;  // above half the sample rate
        // The bandwidth is the power times half the sample rate.
        const std::size_t decimation = k < kHigh ? decimation_ : 1;
        level(carrier, power, 2 * kLevelling / power / static_cast<double>(decimation), energy);
        float peak = 0;
        best_version<find_peak>(std::span<const float>(carrier), peak);
        step_[k] = peak / kSteps;
        std::vector<std::int16_t>& whole = carriers_[k];
        best_version<quantise>(std::span<const float>(carrier), step_[k], whole.data());
        std::copy_n(whole.begin(), kMaxRead_samples,
                    whole.begin() + static_cast<std::ptrdiff_t>(carrier.size()));
    };
    split.carriers(0, kHigh, filters.weights(), low, keep);
    split.carriers(kHigh, kCount, filters.weights(), high, keep);
}

std::size_t NoiseCarriers::fast_period(double sample_rate_hz, std::size_t least) {
    return Fft::fast_size(least, 2 * decimation_of(sample_rate_hz));
}

std::uint64_t NoiseCarriers::source_seed(std::uint64_t seed, std::string_view source) {
    return derive_seed(seed, 1, hash(source));
}

std::uint64_t NoiseCarriers::waves_seed(std::uint64_t room, std::string_view source) const {
    return derive_seed(source_seed(seed_, source), room);
}

std::size_t NoiseCarriers::offset(std::uint64_t room, std::string_view source,
                                  std::size_t channel) const {
    assert(channel < kMaxChannels);
    // The channels of a source are spaced evenly over the period, those of low orders farthest
    // apart.
    constexpr std::size_t kStride = 7;  // has no factor in common with kMaxChannels
    const std::size_t apart = channel * kStride % kMaxChannels * period_samples_ / kMaxChannels;
    return (waves_seed(room, source) % period_samples_ + apart) % period_samples_;
}

std::size_t NoiseCarriers::memory_bytes() const {
    std::size_t bytes = 0;
    for (const std::vector<std::int16_t>& carrier : carriers_)
        bytes += carrier.size() * sizeof(std::int16_t);
    return bytes;
}

}  // namespace aula
