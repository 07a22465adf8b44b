#include "apps/room/images/pulse_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>
#include <type_traits>

#include "audio/dsp/fft.h"
#include "process/multiversion.h"

namespace aula {

namespace {

/// [tap * kFiner + finer sample] The middle is at kPulseTaps * kFiner / 2.
std::vector<float> make_low_pass() {
    std::vector<float> taps(kPulseTaps * kFiner);
    for (std::size_t i = 0; i < taps.size(); ++i) {
        const double x = std::numbers::pi *
                         (static_cast<double>(i) - static_cast<double>(taps.size()) / 2) /
                         static_cast<double>(kFiner);
        const double window = 0.5 + 0.5 * std::cos(2 * x / kPulseTaps);
        taps[i] = static_cast<float>(window * (x == 0 ? 1 : std::sin(x) / x));
    }
    return taps;
}

/// Values that are filtered together: samples of one signal, or the octaves of one sample.
using Samples = float __attribute__((vector_size(16 * sizeof(float))));
using Octaves = float __attribute__((vector_size(kBandCount * sizeof(float))));

/// The products of kPulseTaps * kFiner samples with the taps of the filter, added up.
AULA_MULTIVERSION void filter(const float* from, const float* taps, float& sum) {
    // Four sums: additions do not wait for each other.
    std::array<Samples, 4> sums{};
    for (std::size_t tap = 0; tap < kPulseTaps * kFiner; tap += 64) {
        for (std::size_t k = 0; k < 4; ++k) {
            Samples x, y;
            std::memcpy(&x, from + tap + 16 * k, sizeof x);
            std::memcpy(&y, taps + tap + 16 * k, sizeof y);
            sums[k] += x * y;
        }
    }
    const Samples all = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    sum = 0;
    for (std::size_t k = 0; k < 16; ++k) sum += all[k];
}

AULA_MULTIVERSION void filter_octaves(const Bands* from, const float* taps, Bands& sum) {
    std::array<Octaves, 4> sums{};
    for (std::size_t tap = 0; tap < kPulseTaps * kFiner; tap += 4) {
        for (std::size_t k = 0; k < 4; ++k) {
            Octaves x;
            std::memcpy(&x, from[tap + k].value.data(), sizeof x);
            sums[k] += x * taps[tap + k];
        }
    }
    const Octaves all = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (std::size_t b = 0; b < kBandCount; ++b) sum[b] = all[b];
}

/// The gain of a band at a frequency: octaves with cosine flanks as wide as an octave between their
/// centres, which add up to 1. The lowest and highest extend to 0 Hz and to half the sample rate.
double octave_gain(std::size_t band, double hz) {
    const double at = std::log2(std::max(hz, 1.0) / double{kBandCentres_hz[0]});
    const double away = std::clamp(at, 0.0, double{kBandCount} - 1) - static_cast<double>(band);
    return std::abs(away) >= 1 ? 0 : 0.5 + 0.5 * std::cos(std::numbers::pi * away);
}

template <typename Value>
std::vector<Value> filtered(const std::vector<Value>& finer, std::size_t samples) {
    static const std::vector<float> low_pass = make_low_pass();
    std::vector<Value> result(samples, Value{});
    for (std::size_t i = 0; i < samples; ++i) {
        if constexpr (std::is_same_v<Value, float>)
            best_version<filter>(finer.data() + i * kFiner, low_pass.data(), result[i]);
        else
            best_version<filter_octaves>(finer.data() + i * kFiner, low_pass.data(), result[i]);
    }
    return result;
}

}  // namespace

std::vector<float> coarser(const std::vector<float>& finer, std::size_t samples) {
    return filtered(finer, samples);
}

std::vector<Bands> coarser(const std::vector<Bands>& finer, std::size_t samples) {
    return filtered(finer, samples);
}

std::vector<float> joined(const std::vector<Bands>& octaves, double sample_rate_hz) {
    RealFft fft(fast_fft_size(2 * octaves.size()));
    std::vector<float> signal(fft.size());
    std::vector<std::complex<float>> spectrum(fft.bins()), sum(fft.bins());
    for (std::size_t band = 0; band < kBandCount; ++band) {
        std::fill(signal.begin(), signal.end(), 0.0F);
        for (std::size_t i = 0; i < octaves.size(); ++i) signal[i] = octaves[i][band];
        fft.forward(signal.data(), spectrum.data());
        for (std::size_t k = 0; k < sum.size(); ++k)
            sum[k] += spectrum[k] *
                      static_cast<float>(octave_gain(band, static_cast<double>(k) * sample_rate_hz /
                                                               static_cast<double>(fft.size())) /
                                         static_cast<double>(fft.size()));
    }
    fft.inverse(sum.data(), signal.data());
    signal.resize(octaves.size());
    return signal;
}

}  // namespace aula
