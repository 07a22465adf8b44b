#include "tests/audio/convolution/signals.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"

namespace aula::test {

namespace {

struct Spectrum {
    AlignedVector<std::complex<float>> bins;
    double bin_hz = 0;
};

Spectrum transform(const Signal& signal, bool windowed, double sample_rate_hz) {
    RealFft fft(std::bit_ceil(signal.size()));
    AlignedVector<float> padded(fft.size());
    for (std::size_t n = 0; n < signal.size(); ++n) {
        const double phase = 2 * std::numbers::pi * (static_cast<double>(n) + 0.5) /
                             static_cast<double>(signal.size());
        // Blackman-Harris, four terms: side lobes of -92 dB.
        const double window = 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) -
                              0.01168 * std::cos(3 * phase);
        padded[n] = signal[n] * static_cast<float>(windowed ? window : 1.0);
    }
    Spectrum spectrum;
    spectrum.bins.resize(fft.bins());
    spectrum.bin_hz = sample_rate_hz / static_cast<double>(fft.size());
    fft.forward(padded.data(), spectrum.bins.data());
    return spectrum;
}

}  // namespace

Signals random_signals(std::size_t count, std::size_t samples, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    Signals signals(count, Signal(samples));
    for (Signal& signal : signals) {
        for (float& x : signal) x = normal(random);
    }
    return signals;
}

Signal sine(double frequency_hz, std::size_t samples, double sample_rate_hz) {
    Signal signal(samples);
    for (std::size_t n = 0; n < samples; ++n) {
        signal[n] = static_cast<float>(std::sin(2 * std::numbers::pi * frequency_hz *
                                                static_cast<double>(n) / sample_rate_hz));
    }
    return signal;
}

double energy_outside_db(const Signal& signal, double centre_hz, double distance_hz,
                         double sample_rate_hz) {
    const Spectrum spectrum = transform(signal, true, sample_rate_hz);
    double total = 0;
    double outside = 0;
    for (std::size_t k = 0; k < spectrum.bins.size(); ++k) {
        const double energy = double{std::norm(spectrum.bins[k])};
        const double frequency_hz = static_cast<double>(k) * spectrum.bin_hz;
        total += energy;
        if (std::abs(frequency_hz - centre_hz) > distance_hz) outside += energy;
    }
    return 10 * std::log10(outside / total);
}

double peak_outside_db(const Signal& signal, double centre_hz, double distance_hz,
                       double sample_rate_hz) {
    Spectrum spectrum = transform(signal, true, sample_rate_hz);
    AlignedVector<std::complex<float>> rest = spectrum.bins;
    for (std::size_t k = 0; k < rest.size(); ++k) {
        const double frequency_hz = static_cast<double>(k) * spectrum.bin_hz;
        if (std::abs(frequency_hz - centre_hz) <= distance_hz) rest[k] = 0;
    }
    RealFft fft(2 * (rest.size() - 1));
    AlignedVector<float> samples(fft.size());
    const auto peak = [&](AlignedVector<std::complex<float>>& bins) {
        fft.inverse(bins.data(), samples.data());
        float largest = 0;
        for (const float x : samples) largest = std::max(largest, std::abs(x));
        return double{largest};
    };
    return 20 * std::log10(peak(rest) / peak(spectrum.bins));
}

double band_energy(const Signal& signal, double from_hz, double to_hz, double sample_rate_hz) {
    const Spectrum spectrum = transform(signal, false, sample_rate_hz);
    double energy = 0;
    for (std::size_t k = 0; k < spectrum.bins.size(); ++k) {
        const double frequency_hz = static_cast<double>(k) * spectrum.bin_hz;
        if (frequency_hz >= from_hz && frequency_hz < to_hz) {
            energy += double{std::norm(spectrum.bins[k])};
        }
    }
    return energy;
}

}  // namespace aula::test
