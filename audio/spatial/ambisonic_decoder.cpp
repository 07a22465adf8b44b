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

// An order N follows the phase of the ears as far as N wavelengths go round the head; below this
// nothing is gained by giving it up.
constexpr double kLowestCut_hz = 1500;
constexpr double kHeadRadius_m = 0.0875;
constexpr double kSpeed_m_s = 343;

constexpr double kLead_s = 0.001;

// Ears that have more in common than in the set are mixed to have less, and what is mixed is lost
// to the level differences of single directions: 7 dB of 20 at 8 kHz, were it done to the end. A
// coherence of so much is not told from none.
constexpr double kUnheardCoherence = 0.09;

// The square of the error counts by the inverse of the magnitude, or the ear that is turned away
// from the sound would be lost in the other's error; below -40 dB no more than at -40 dB.
constexpr double kLeastEnergy = 1e-4;

double magnitude_only_hz(int order) {
    return std::max(kLowestCut_hz, order * kSpeed_m_s / (2 * std::numbers::pi * kHeadRadius_m));
}

/// A positive semidefinite Hermitian matrix of the two ears.
struct Covariance {
    double left = 0;
    double right = 0;
    Complex cross = 0;  ///< left times conjugate right

    Covariance scaled(double k) const { return {k * left, k * right, k * cross}; }
    double determinant() const { return std::max(0.0, left * right - std::norm(cross)); }

    // Cayley and Hamilton: sqrt(A) = (A + sqrt(det A)) / sqrt(tr A + 2 sqrt(det A)).
    Covariance root() const {
        const double d = std::sqrt(determinant());
        const double scale = std::sqrt(left + right + 2 * d);
        return Covariance{left + d, right + d, cross}.scaled(1 / scale);
    }

    Covariance inverse() const { return Covariance{right, left, -cross}.scaled(1 / determinant()); }

    /// this * middle * this
    Covariance around(const Covariance& middle) const {
        const Complex a = left * middle.left + cross * std::conj(middle.cross);
        const Complex b = left * middle.cross + cross * middle.right;
        const Complex c = std::conj(cross) * middle.left + right * std::conj(middle.cross);
        const Complex d = std::conj(cross) * middle.cross + right * middle.right;
        return {(a * left + b * std::conj(cross)).real(), (c * cross + d * right).real(),
                a * cross + b * right};
    }
};

// The mixing of the ears that turns the covariance `is` into `wanted` and changes the signals
// least: M = W (W S W)^-1 W with W = sqrt(wanted), S = is, and the root taken of the product in
// brackets.
Covariance correction(Covariance is, Covariance wanted) {
    // At low frequencies both ears are the same: keep the matrices regular.
    constexpr double kFloor = 1e-7;
    const double floor = kFloor * (wanted.left + wanted.right);
    for (Covariance* c : {&is, &wanted}) {
        c->left += floor;
        c->right += floor;
    }
    const Covariance w = wanted.root();
    return w.around(w.around(is).root().inverse());
}

/// What is wanted, with as much of the coherence that is as is not heard.
Covariance within_hearing(const Covariance& is, Covariance wanted) {
    const double level = std::sqrt(wanted.left * wanted.right);
    const Complex excess = level / std::sqrt(is.left * is.right) * is.cross - wanted.cross;
    wanted.cross += excess * std::min(1.0, kUnheardCoherence * level / std::abs(excess));
    return wanted;
}

/// The responses of one ear at all directions with their delays re the middle of the head:
/// [bin][direction].
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

/// Directions in rows, channels in columns.
std::vector<std::vector<double>> encodings(const HeadResponses& head, std::size_t channels) {
    std::vector<std::vector<double>> rows;
    for (const std::array<float, 3>& direction : head.directions) {
        const auto gains = encode_direction(direction);
        rows.emplace_back(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(channels));
    }
    return rows;
}

// The weights d that minimise sum over i of w_i |H_i - Y_i d|^2 are (Y^T W Y)^-1 Y^T W H. This is
// the matrix before H, [channel][direction], by Gauss and Jordan; Y^T W Y is symmetric and positive
// definite, so no pivoting.
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

/// What the weights make of a plane wave.
Complex decoded(const std::vector<double>& encoding, const Weights& weights) {
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

/// The weights whose magnitudes are nearest to those of the responses, from some that are near.
Weights fit_magnitudes(const std::vector<Complex>& responses, const HeadResponses& head,
                       const std::vector<std::vector<double>>& encoding, const Weights& weights) {
    double mean = 0;
    for (std::size_t i = 0; i < responses.size(); ++i) {
        mean += head.weights[i] * std::norm(responses[i]);
    }
    std::vector<double> importance(responses.size());
    for (std::size_t i = 0; i < responses.size(); ++i) {
        importance[i] = head.weights[i] / std::sqrt(std::norm(responses[i]) / mean + kLeastEnergy);
    }
    const auto solution = least_squares(encoding, importance, weights.size());
    std::vector<Complex> turned(responses.size());
    for (std::size_t i = 0; i < responses.size(); ++i) {
        turned[i] = std::polar(std::abs(responses[i]), std::arg(decoded(encoding[i], weights)));
    }
    return times(solution, turned);
}

/// Both ears' covariance in a diffuse field, whose channels are uncorrelated and have the energies
/// 1 / (2 l + 1) each.
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

/// The same as the responses give it.
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

void mix(const Covariance& by, std::array<Weights, 2>& weights) {
    for (std::size_t c = 0; c < weights[0].size(); ++c) {
        const Complex left = weights[0][c];
        const Complex right = weights[1][c];
        weights[0][c] = by.left * left + by.cross * right;
        weights[1][c] = std::conj(by.cross) * left + by.right * right;
    }
}

}  // namespace

std::size_t decoder_lead_samples(double sample_rate_hz) {
    return static_cast<std::size_t>(std::lround(kLead_s * sample_rate_hz));
}

// At each frequency the weights d of an ear minimise sum over i of w_i |H_i - Y_i d|^2. Where only
// the magnitude counts, H_i takes on the phase that the weights of the bin below give direction i:
// from bin to bin magnitudes and phases settle; more rounds in a bin gain nothing. Then what
// becomes of a diffuse field is corrected.
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
            design == DecoderDesign::magnitudes && frequency_hz > magnitude_only_hz(order);
        for (std::size_t ear = 0; ear < 2; ++ear) {
            weights[ear] = fit ? fit_magnitudes(responses[ear][k], head, encoding, weights[ear])
                               : times(solution, responses[ear][k]);
        }
        if (design == DecoderDesign::magnitudes) {
            const Covariance is = diffuse_covariance(weights);
            const Covariance wanted = diffuse_covariance(head, responses[0][k], responses[1][k]);
            mix(correction(is, fit ? within_hearing(is, wanted) : wanted), weights);
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
            // The response is real: so is its spectrum at the Nyquist frequency.
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
