#include "audio/spatial/ambisonic_decoder.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <complex>
#include <numbers>

#include "audio/base/aligned.h"
#include "audio/dsp/fft.h"
#include "audio/spatial/ambisonics.h"

namespace aula {

namespace {

using Complex = std::complex<double>;

// Order N reproduces the phase at the ears up to the frequency at which the head's circumference is
// N wavelengths. A cutoff below 1500 Hz gains nothing.
constexpr double kLowestCutoff_hz = 1500;
constexpr double kHeadRadius_m = 0.0875;
constexpr double kSpeed_m_s = 343;

constexpr double kLead_s = 0.001;

// Mixing the ears for a lower coherence reduces the level differences of single directions: by 7 dB
// of 20 dB at 8 kHz for the exact target. An excess of this much is inaudible and is left.
constexpr double kInaudibleCoherence = 0.09;

// Squared errors are weighted by the inverse magnitude; otherwise the contralateral responses would
// hardly count. Magnitudes below -40 dB are weighted as -40 dB.
constexpr double kEnergyFloor = 1e-4;

double magnitude_cutoff_hz(int order) {
    return std::max(kLowestCutoff_hz, order * kSpeed_m_s / (2 * std::numbers::pi * kHeadRadius_m));
}

/// A positive semidefinite Hermitian matrix of the two ears.
struct Covariance {
    double left = 0;
    double right = 0;
    Complex cross = 0;  ///< mean of left times conjugate right

    Covariance scaled(double k) const { return {k * left, k * right, k * cross}; }
    double determinant() const { return std::max(0.0, left * right - std::norm(cross)); }

    // By Cayley and Hamilton: sqrt(A) = (A + sqrt(det A) I) / sqrt(tr A + 2 sqrt(det A)).
    Covariance root() const {
        const double d = std::sqrt(determinant());
        const double scale = std::sqrt(left + right + 2 * d);
        return Covariance{left + d, right + d, cross}.scaled(1 / scale);
    }

    Covariance inverse() const { return Covariance{right, left, -cross}.scaled(1 / determinant()); }

    /// this * middle * this
    Covariance congruent(const Covariance& middle) const {
        const Complex a = left * middle.left + cross * std::conj(middle.cross);
        const Complex b = left * middle.cross + cross * middle.right;
        const Complex c = std::conj(cross) * middle.left + right * std::conj(middle.cross);
        const Complex d = std::conj(cross) * middle.cross + right * middle.right;
        return {(a * left + b * std::conj(cross)).real(), (c * cross + d * right).real(),
                a * cross + b * right};
    }
};

// The mixing matrix that maps the covariance `actual` to `target` with the least change of the
// signals (optimal covariance mixing, Vilkamo, Baeckstroem and Kuntz 2013): M = W (W S W)^(-1/2) W
// with W = sqrt(target) and S = actual.
Covariance optimal_mixing(Covariance actual, Covariance target) {
    // At low frequencies both ears are equal: regularise the matrices.
    constexpr double kFloor = 1e-7;
    const double floor = kFloor * (target.left + target.right);
    for (Covariance* c : {&actual, &target}) {
        c->left += floor;
        c->right += floor;
    }
    const Covariance w = target.root();
    return w.congruent(w.congruent(actual).root().inverse());
}

/// The covariance `target`, moved towards the coherence of `actual` by up to the inaudible amount.
Covariance relax_coherence(const Covariance& actual, Covariance target) {
    const double level = std::sqrt(target.left * target.right);
    const Complex excess =
        level / std::sqrt(actual.left * actual.right) * actual.cross - target.cross;
    target.cross += excess * std::min(1.0, kInaudibleCoherence * level / std::abs(excess));
    return target;
}

/// Transfer functions of one ear with delays re the centre of the head, [bin][direction].
std::vector<std::vector<Complex>> ear_spectra(const HeadResponses& head, std::size_t ear,
                                              RealFft& fft) {
    AlignedVector<float> signal(fft.size());
    AlignedVector<std::complex<float>> spectrum(fft.bins());
    const double centre_s = head.centre_delay_s();
    std::vector<std::vector<Complex>> spectra(fft.bins(),
                                              std::vector<Complex>(head.directions.size()));
    for (std::size_t i = 0; i < head.directions.size(); ++i) {
        const Hrtf::Ear& response = head.ears[i][ear];
        std::fill(
            std::copy(response.minimum_phase.begin(), response.minimum_phase.end(), signal.begin()),
            signal.end(), 0.0F);
        fft.forward(signal.data(), spectrum.data());
        const double step = -2 * std::numbers::pi * (response.delay_s - centre_s) *
                            head.sample_rate_hz / static_cast<double>(fft.size());
        for (std::size_t k = 0; k < fft.bins(); ++k) {
            spectra[k][i] = Complex(spectrum[k]) * std::polar(1.0, step * static_cast<double>(k));
        }
    }
    return spectra;
}

/// Gains that encode each direction, [direction][channel].
std::vector<std::vector<double>> encodings(const HeadResponses& head, std::size_t channels) {
    std::vector<std::vector<double>> rows;
    for (const std::array<float, 3>& direction : head.directions) {
        const auto gains = encode_direction(direction);
        rows.emplace_back(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(channels));
    }
    return rows;
}

// The weights d that minimise sum over i of w_i |H_i - Y_i d|^2 are (Y^T W Y)^-1 Y^T W H. Returns
// the factor of H, [channel][direction], by Gauss-Jordan elimination. Y^T W Y is symmetric and
// positive definite: no pivoting is needed.
std::vector<std::vector<double>> least_squares(const std::vector<std::vector<double>>& encoding,
                                               const std::vector<double>& weights,
                                               std::size_t channels) {
    const std::size_t count = encoding.size();
    std::vector<std::vector<double>> normal(channels, std::vector<double>(channels));
    std::vector<std::vector<double>> solution(channels, std::vector<double>(count));
    for (std::size_t r = 0; r < channels; ++r) {
        for (std::size_t i = 0; i < count; ++i) {
            solution[r][i] = weights[i] * encoding[i][r];
            for (std::size_t c = 0; c < channels; ++c) {
                normal[r][c] += solution[r][i] * encoding[i][c];
            }
        }
    }
    const auto add_row = [&](std::size_t to, std::size_t from, double factor) {
        for (std::size_t c = 0; c < channels; ++c) normal[to][c] += factor * normal[from][c];
        for (std::size_t i = 0; i < count; ++i) solution[to][i] += factor * solution[from][i];
    };
    for (std::size_t p = 0; p < channels; ++p) {
        add_row(p, p, 1 / normal[p][p] - 1);
        for (std::size_t r = 0; r < channels; ++r) {
            if (r != p) add_row(r, p, -normal[r][p]);
        }
    }
    return solution;
}

using Weights = std::vector<Complex>;

/// The ear signal of a plane wave of unit amplitude.
Complex decode(const std::vector<double>& encoding, const Weights& weights) {
    Complex sum = 0;
    for (std::size_t c = 0; c < weights.size(); ++c) sum += encoding[c] * weights[c];
    return sum;
}

Weights times(const std::vector<std::vector<double>>& solution, const std::vector<Complex>& h) {
    Weights weights;
    for (const std::vector<double>& row : solution) {
        Complex sum = 0;
        for (std::size_t i = 0; i < h.size(); ++i) sum += row[i] * h[i];
        weights.push_back(sum);
    }
    return weights;
}

/// One iteration of magnitude least squares from the initial `weights`.
Weights fit_magnitudes(const std::vector<Complex>& responses, const HeadResponses& head,
                       const std::vector<std::vector<double>>& encoding, const Weights& weights) {
    double mean = 0;
    for (std::size_t i = 0; i < responses.size(); ++i) {
        mean += head.weights[i] * std::norm(responses[i]);
    }
    std::vector<double> error_weights(responses.size());
    for (std::size_t i = 0; i < responses.size(); ++i) {
        error_weights[i] =
            head.weights[i] / std::sqrt(std::norm(responses[i]) / mean + kEnergyFloor);
    }
    const auto solution = least_squares(encoding, error_weights, weights.size());
    std::vector<Complex> target(responses.size());
    for (std::size_t i = 0; i < responses.size(); ++i) {
        target[i] = std::polar(std::abs(responses[i]), std::arg(decode(encoding[i], weights)));
    }
    return times(solution, target);
}

/// Covariance of the decoded ears in a diffuse field. Its channels are uncorrelated and have the
/// energy 1 / (2 l + 1).
Covariance diffuse_covariance(const std::array<Weights, 2>& weights) {
    Covariance sum;
    for (std::size_t c = 0; c < weights[0].size(); ++c) {
        const double energy = 1.0 / (2 * order_of_channel(c) + 1);
        sum.left += energy * std::norm(weights[0][c]);
        sum.right += energy * std::norm(weights[1][c]);
        sum.cross += energy * weights[0][c] * std::conj(weights[1][c]);
    }
    return sum;
}

/// Covariance of the ears in a diffuse field according to the head responses.
Covariance diffuse_covariance(const HeadResponses& head, const std::vector<Complex>& left,
                              const std::vector<Complex>& right) {
    Covariance sum;
    for (std::size_t i = 0; i < left.size(); ++i) {
        sum.left += head.weights[i] * std::norm(left[i]);
        sum.right += head.weights[i] * std::norm(right[i]);
        sum.cross += head.weights[i] * left[i] * std::conj(right[i]);
    }
    return sum;
}

void mix(const Covariance& matrix, std::array<Weights, 2>& weights) {
    for (std::size_t c = 0; c < weights[0].size(); ++c) {
        const Complex left = weights[0][c];
        const Complex right = weights[1][c];
        weights[0][c] = matrix.left * left + matrix.cross * right;
        weights[1][c] = std::conj(matrix.cross) * left + matrix.right * right;
    }
}

}  // namespace

std::size_t decoder_lead_samples(double sample_rate_hz) {
    return static_cast<std::size_t>(std::lround(kLead_s * sample_rate_hz));
}

// At each frequency the weights d of an ear minimise sum over i of w_i |H_i - Y_i d|^2. Above the
// cutoff the phase of H_i is replaced by that which the weights of the bin below give direction i.
// This converges from bin to bin; several iterations per bin gain nothing. Finally the
// diffuse-field covariance is corrected.
AmbisonicDecoder design_decoder(const HeadResponses& head, int order, DecoderDesign design) {
    assert(order >= 1 && order <= kHighestAmbisonicOrder);
    const std::size_t channels = ambisonic_channels(order);
    const std::size_t response_taps = head.ears[0][0].minimum_phase.size();
    const std::size_t size = std::bit_ceil(4 * response_taps);
    RealFft fft(size);
    const std::vector<std::vector<double>> encoding = encodings(head, channels);
    const auto solution = least_squares(encoding, head.weights, channels);
    const std::array<std::vector<std::vector<Complex>>, 2> responses{ear_spectra(head, 0, fft),
                                                                     ear_spectra(head, 1, fft)};
    const double bin_hz = head.sample_rate_hz / static_cast<double>(size);
    const double delay_s =
        head.centre_delay_s() +
        static_cast<double>(decoder_lead_samples(head.sample_rate_hz)) / head.sample_rate_hz;

    std::array<Weights, 2> weights;
    std::array<std::vector<AlignedVector<std::complex<float>>>, 2> spectra;
    for (auto& ear : spectra) {
        ear.assign(channels, AlignedVector<std::complex<float>>(fft.bins()));
    }
    for (std::size_t k = 0; k < fft.bins(); ++k) {
        const double frequency_hz = static_cast<double>(k) * bin_hz;
        const bool fit =
            design == DecoderDesign::magnitudes && frequency_hz > magnitude_cutoff_hz(order);
        for (std::size_t ear = 0; ear < 2; ++ear) {
            weights[ear] = fit ? fit_magnitudes(responses[ear][k], head, encoding, weights[ear])
                               : times(solution, responses[ear][k]);
        }
        if (design == DecoderDesign::magnitudes) {
            const Covariance actual = diffuse_covariance(weights);
            const Covariance target = diffuse_covariance(head, responses[0][k], responses[1][k]);
            mix(optimal_mixing(actual, fit ? relax_coherence(actual, target) : target), weights);
        }
        const Complex delay = std::polar(1.0, -2 * std::numbers::pi * delay_s * frequency_hz);
        for (std::size_t ear = 0; ear < 2; ++ear) {
            for (std::size_t c = 0; c < channels; ++c)
                spectra[ear][c][k] = std::complex<float>(delay * weights[ear][c]);
        }
    }

    AmbisonicDecoder decoder;
    const std::size_t taps = fast_fft_size(response_taps + response_taps / 2);
    AlignedVector<float> signal(size);
    for (std::size_t ear = 0; ear < 2; ++ear) {
        for (AlignedVector<std::complex<float>>& spectrum : spectra[ear]) {
            // The spectrum of a real response is real at the Nyquist frequency.
            spectrum.back() = spectrum.back().real();
            fft.inverse(spectrum.data(), signal.data());
            std::vector<float>& out = decoder[ear].emplace_back(
                signal.begin(), signal.begin() + static_cast<std::ptrdiff_t>(taps));
            for (float& x : out) x /= static_cast<float>(size);
            fade_out(out);
        }
    }
    return decoder;
}

}  // namespace aula
