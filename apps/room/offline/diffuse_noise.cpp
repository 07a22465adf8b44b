#include "apps/room/offline/diffuse_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>

#include "audio/dsp/fft.h"
#include "engine/base/sampling.h"

namespace aula {

namespace {

/// One factor serves the frequencies from f to f + max(kWidth_hz, f / kWidths). The error of kd, in
/// proportion, is 1 / (2 kWidths); below kWidth_hz, for points within 3 m, kd is below 0.2.
constexpr double kWidth_hz = 4;
constexpr double kWidths = 50;

using Spectrum = std::vector<std::complex<float>>;

double sinc(double x) { return x < 1e-6 ? 1 : std::sin(x) / x; }

/// Lower triangular L, row by row, with L L^T = the matrix of sin(kd) / (kd). The matrix may be
/// singular, as at 0 Hz, where all points hear the same: then columns of L are zero.
std::vector<double> cholesky_factor(const std::vector<double>& distances_m, std::size_t points,
                                    double wavenumber_1_m) {
    constexpr double kNothing = 1e-9;
    std::vector<double> factor(points * (points + 1) / 2);
    const auto row = [&](std::size_t i) { return factor.data() + i * (i + 1) / 2; };
    for (std::size_t i = 0; i < points; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double rest = sinc(wavenumber_1_m * distances_m[i * points + j]);
            for (std::size_t k = 0; k < j; ++k) rest -= row(i)[k] * row(j)[k];
            if (i == j) {
                row(i)[j] = rest > kNothing ? std::sqrt(rest) : 0;
            } else {
                row(i)[j] = row(j)[j] > 0 ? rest / row(j)[j] : 0;
            }
        }
    }
    return factor;
}

/// Uniform white noise of unit variance.
std::vector<float> white_noise(std::size_t count, std::uint64_t seed) {
    RandomStream random(seed);
    std::vector<float> noise(count);
    for (float& x : noise)
        x = (static_cast<float>(random.bits() >> 40) * 0x1p-24F - 0.5F) * std::sqrt(12.0F);
    return noise;
}

/// Mixes the independent spectra of a set of points in place.
void mix(std::span<const Vec3> points, std::span<Spectrum> spectra, double bin_hz,
         double speed_of_sound_m_s) {
    const std::size_t count = points.size();
    std::vector<double> distances_m(count * count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j)
            distances_m[i * count + j] = double{glm::distance(points[i], points[j])};
    const std::size_t bins = spectra[0].size();
    for (std::size_t first = 0; first < bins;) {
        const double first_hz = static_cast<double>(first) * bin_hz;
        const double width_hz = std::max(kWidth_hz, first_hz / kWidths);
        const std::size_t end = std::min(
            bins, first + std::max<std::size_t>(1, static_cast<std::size_t>(width_hz / bin_hz)));
        const double middle_hz = (static_cast<double>(first + end - 1) / 2) * bin_hz;
        const std::vector<double> factor = cholesky_factor(
            distances_m, count, 2 * std::numbers::pi * middle_hz / speed_of_sound_m_s);
        // From the last point to the first, which overwrites only spectra that are not used again.
        for (std::size_t i = count; i-- > 0;) {
            const double* const row = factor.data() + i * (i + 1) / 2;
            for (std::size_t bin = first; bin < end; ++bin)
                spectra[i][bin] *= static_cast<float>(row[i]);
            for (std::size_t j = 0; j < i; ++j) {
                const auto share = static_cast<float>(row[j]);
                for (std::size_t bin = first; bin < end; ++bin)
                    spectra[i][bin] += share * spectra[j][bin];
            }
        }
        first = end;
    }
}

}  // namespace

DiffuseNoise::DiffuseNoise(std::span<const Vec3> points, std::size_t samples, double sample_rate_hz,
                           double speed_of_sound_m_s, std::uint64_t seed) {
    RealFft fft(fast_fft_size(samples));
    const double bin_hz = sample_rate_hz / static_cast<double>(fft.size());
    std::vector<Spectrum> spectra(points.size(), Spectrum(fft.bins()));
    for (std::size_t i = 0; i < points.size(); ++i)
        fft.forward(white_noise(fft.size(), derive_seed(seed, i)).data(), spectra[i].data());
    mix(points, spectra, bin_hz, speed_of_sound_m_s);
    for (Spectrum& spectrum : spectra) {
        for (std::complex<float>& x : spectrum) x /= static_cast<float>(fft.size());
        std::vector<float>& noise = noises_.emplace_back(fft.size());
        fft.inverse(spectrum.data(), noise.data());
        spectrum = {};
    }
}

}  // namespace aula
