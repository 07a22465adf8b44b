#include "audio/head_responses.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "audio/aligned.h"
#include "audio/fft.h"

namespace aula {

namespace {

// First order follows the phase of the ears about as far as the head is small against the wave.
constexpr double kMagnitudeOnly_hz = 1500;

using Row = std::array<double, 4>;
using Matrix = std::array<Row, 4>;
using Weights = std::array<std::complex<double>, 4>;

Row encode(const std::array<float, 3>& direction) {
    return {1, double{direction[1]}, double{direction[2]}, double{direction[0]}};
}

/// Gauss-Jordan; the matrix is symmetric and positive definite, so no pivoting.
Matrix inverted(Matrix a) {
    Matrix inverse{};
    for (std::size_t i = 0; i < 4; ++i) inverse[i][i] = 1;
    for (std::size_t i = 0; i < 4; ++i) {
        const double pivot = a[i][i];
        for (std::size_t j = 0; j < 4; ++j) {
            a[i][j] /= pivot;
            inverse[i][j] /= pivot;
        }
        for (std::size_t r = 0; r < 4; ++r) {
            if (r == i) continue;
            const double factor = a[r][i];
            for (std::size_t j = 0; j < 4; ++j) {
                a[r][j] -= factor * a[i][j];
                inverse[r][j] -= factor * inverse[i][j];
            }
        }
    }
    return inverse;
}

std::complex<double> decoded(const Row& encoding, const Weights& weights) {
    std::complex<double> sum = 0;
    for (std::size_t c = 0; c < 4; ++c) sum += encoding[c] * weights[c];
    return sum;
}

/// The responses of one ear at all directions with their delays re the middle of the head:
/// [direction][bin].
std::vector<std::vector<std::complex<double>>> ear_spectra(const HeadResponses& head,
                                                           std::size_t ear, RealFft& fft) {
    AlignedVector<float> signal(fft.size());
    AlignedVector<std::complex<float>> spectrum(fft.bins());
    const double centre_s = head.centre_delay_s();
    std::vector<std::vector<std::complex<double>>> spectra;
    for (const auto& ears : head.ears) {
        std::fill(std::copy(ears[ear].minimum_phase.begin(), ears[ear].minimum_phase.end(),
                            signal.begin()),
                  signal.end(), 0.0F);
        fft.forward(signal.data(), spectrum.data());
        std::vector<std::complex<double>>& bins = spectra.emplace_back(fft.bins());
        const double step = -2 * std::numbers::pi * (ears[ear].delay_s - centre_s) *
                            head.sample_rate_hz / static_cast<double>(fft.size());
        for (std::size_t k = 0; k < bins.size(); ++k) {
            bins[k] =
                std::complex<double>(spectrum[k]) * std::polar(1.0, step * static_cast<double>(k));
        }
    }
    return spectra;
}

}  // namespace

double HeadResponses::centre_delay_s() const {
    double sum = 0;
    for (std::size_t i = 0; i < ears.size(); ++i) {
        sum += weights[i] * 0.5 * (ears[i][0].delay_s + ears[i][1].delay_s);
    }
    return sum;
}

std::vector<double> sphere_shares(const std::vector<std::array<float, 3>>& directions) {
    // A Fibonacci lattice covers the sphere evenly; each point counts for its nearest direction.
    constexpr std::size_t kPoints = 20000;
    std::vector<double> shares(directions.size());
    for (std::size_t p = 0; p < kPoints; ++p) {
        const double z = 1 - (2 * static_cast<double>(p) + 1) / static_cast<double>(kPoints);
        const double azimuth = std::numbers::pi * (3 - std::sqrt(5.0)) * static_cast<double>(p);
        const double radius = std::sqrt(1 - z * z);
        const std::array<float, 3> point{static_cast<float>(radius * std::cos(azimuth)),
                                         static_cast<float>(radius * std::sin(azimuth)),
                                         static_cast<float>(z)};
        std::size_t nearest = 0;
        float best = -2;
        for (std::size_t i = 0; i < directions.size(); ++i) {
            const auto& d = directions[i];
            const float cosine = d[0] * point[0] + d[1] * point[1] + d[2] * point[2];
            if (cosine > best) {
                best = cosine;
                nearest = i;
            }
        }
        shares[nearest] += 1.0 / static_cast<double>(kPoints);
    }
    return shares;
}

// At each frequency the weights d minimise sum over i of w_i |H_i - Y_i d|^2, which is
// d = (Y^T W Y)^-1 Y^T W H. Where only the magnitude counts, H_i takes on the phase that the
// decoder of the bin below gives direction i.
std::array<std::array<std::vector<float>, 4>, 2> design_decoder(const HeadResponses& head,
                                                                std::size_t taps) {
    const std::size_t size = std::bit_ceil(4 * taps);
    RealFft fft(size);
    const std::size_t count = head.directions.size();
    std::vector<Row> encodings;
    Matrix normal{};
    for (std::size_t i = 0; i < count; ++i) {
        const Row& y = encodings.emplace_back(encode(head.directions[i]));
        for (std::size_t r = 0; r < 4; ++r) {
            for (std::size_t c = 0; c < 4; ++c) normal[r][c] += head.weights[i] * y[r] * y[c];
        }
    }
    const Matrix inverse = inverted(normal);
    const double bin_hz = head.sample_rate_hz / static_cast<double>(size);
    const double centre_samples = head.centre_delay_s() * head.sample_rate_hz;

    std::array<std::array<std::vector<float>, 4>, 2> decoder;
    for (std::size_t ear = 0; ear < 2; ++ear) {
        const auto spectra = ear_spectra(head, ear, fft);
        std::array<AlignedVector<std::complex<float>>, 4> bins;
        for (auto& channel : bins) channel.resize(fft.bins());
        Weights before{};
        for (std::size_t k = 0; k < fft.bins(); ++k) {
            Weights projected{};
            double wanted_energy = 0;
            for (std::size_t i = 0; i < count; ++i) {
                std::complex<double> h = spectra[i][k];
                wanted_energy += head.weights[i] * std::norm(h);
                if (static_cast<double>(k) * bin_hz > kMagnitudeOnly_hz) {
                    h = std::polar(std::abs(h), std::arg(decoded(encodings[i], before)));
                }
                for (std::size_t c = 0; c < 4; ++c) {
                    projected[c] += head.weights[i] * encodings[i][c] * h;
                }
            }
            Weights solved{};
            for (std::size_t r = 0; r < 4; ++r) {
                for (std::size_t c = 0; c < 4; ++c) solved[r] += inverse[r][c] * projected[c];
            }
            before = solved;
            // In a diffuse field the channels are uncorrelated, of energy 1 and 1/3 each.
            const double energy =
                std::norm(solved[0]) +
                (std::norm(solved[1]) + std::norm(solved[2]) + std::norm(solved[3])) / 3;
            const std::complex<double> gain =
                std::sqrt(wanted_energy / energy) *
                std::polar(1.0, -2 * std::numbers::pi * centre_samples * static_cast<double>(k) /
                                    static_cast<double>(size));
            for (std::size_t c = 0; c < 4; ++c) {
                bins[c][k] = std::complex<float>(gain * solved[c]);
            }
        }
        AlignedVector<float> signal(size);
        for (std::size_t c = 0; c < 4; ++c) {
            // The response is real: so is its spectrum at the Nyquist frequency.
            bins[c].back() = bins[c].back().real();
            fft.inverse(bins[c].data(), signal.data());
            std::vector<float>& out = decoder[ear][c];
            out.assign(signal.begin(), signal.begin() + static_cast<std::ptrdiff_t>(taps));
            for (float& x : out) x /= static_cast<float>(size);
            fade_out(out);
        }
    }
    return decoder;
}

void fade_out(std::span<float> response) {
    const std::size_t fade = response.size() / 4;
    const std::size_t start = response.size() - fade;
    for (std::size_t n = 0; n < fade; ++n) {
        const double position = (static_cast<double>(n) + 0.5) / static_cast<double>(fade);
        response[start + n] *=
            static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * position));
    }
}

}  // namespace aula
