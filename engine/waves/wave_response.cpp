#include "engine/waves/wave_response.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <tuple>

#include "engine/base/near_field.h"
#include "process/multiversion.h"

namespace aula {

namespace {

using Complex = std::complex<double>;

/// Below this argument the series of the integrals of sine and cosine converges faster than the
/// continued fraction.
constexpr double kSeriesEnd = 3;

/// Terms of the series: the next one, 3^n / n!, is below 2^-53.
constexpr int kSeriesTerms = 30;

/// Terms of the continued fraction at most; from kSeriesEnd on it takes up to 60, as long as a
/// further one changes it by more than some steps of double precision.
constexpr int kFractionTerms = 100;
// Relative change.
constexpr double kExact = 4 * std::numeric_limits<double>::epsilon();

/// 0..1: the part above an edge, at a ratio of wave numbers to it. Smooth: corners would ring.
double share_above(double ratio) {
    const double x = std::clamp(0.5 + std::log2(ratio) / kOctaveFade, 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

/// Adds poles and their residues, with the share of the octaves.
void add_field(const WaveResponse::Octaves& octaves, const Complex& s, double share,
               WaveField& sum) {
    for (std::size_t i = 0; i < octaves.poles.size(); ++i) {
        const Complex pole = octaves.poles[i];
        const Complex upper = share / (s - pole);
        const Complex lower = pole.imag() == 0 ? 0.0 : share / (s - std::conj(pole));
        for (std::size_t c = 0; c < sum.size(); ++c) {
            const Complex residue = octaves.residues[i][c];
            sum[c] += residue * upper + std::conj(residue) * lower;
        }
    }
}

/// Means over an interval of sine and cosine and their integrals Si(x) and Ci(|x|).
struct MeanIntegrals {
    MeanIntegrals(double from, double to) {
        const Antiderivatives low(from);
        const Antiderivatives high(to);
        const double span = to - from;
        sine = (high.sine - low.sine) / span;
        cosine = (high.cosine - low.cosine) / span;
        sine_integral = (high.sine_integral - low.sine_integral) / span;
        cosine_integral = (high.cosine_integral - low.cosine_integral) / span;
    }

    double sine = 0;
    double cosine = 0;
    double sine_integral = 0;
    double cosine_integral = 0;

 private:
    struct Antiderivatives {
        explicit Antiderivatives(double x) : sine(-std::cos(x)), cosine(std::sin(x)) {
            const double positive = std::max(std::abs(x), std::numeric_limits<double>::min());
            const auto [si, ci] = sine_cosine_integrals(positive);
            sine_integral = positive * si + std::cos(x);
            cosine_integral = x * ci - std::sin(x);
        }

        double sine;
        double cosine;
        double sine_integral;
        double cosine_integral;
    };
};

/// A pole and its residues in single precision.
struct PoleTerm {
    float damping = 0;  ///< the real part of s - pole
    float wave_number = 0;
    std::array<float, std::tuple_size_v<WaveField>> real{};
    std::array<float, std::tuple_size_v<WaveField>> imaginary{};
};

/// Wave numbers that are computed together: the lanes of single precision of 512 bits.
constexpr std::size_t kTogether = 16;

/// Real and imaginary parts of a field.
constexpr std::size_t kParts = 2 * std::tuple_size_v<WaveField>;
using Together = float __attribute__((vector_size(kTogether * sizeof(float))));

/// Adds the poles and their conjugates at kTogether wave numbers, each times a share, to the real
/// and imaginary parts of the four spectra.
AULA_MULTIVERSION void add_poles(const PoleTerm* terms, std::size_t count, const float* at,
                                 const float* shares, float* sums) {
    Together k;
    Together share;
    Together sum[kParts];
    std::memcpy(&k, at, sizeof k);
    std::memcpy(&share, shares, sizeof share);
    std::memcpy(sum, sums, sizeof sum);
    for (std::size_t i = 0; i < count; ++i) {
        const PoleTerm& term = terms[i];
        // 1 / (s - pole) and the same of the conjugate pole.
        const Together below = k - term.wave_number;
        const Together above = k + term.wave_number;
        const Together upper = share / (term.damping * term.damping + below * below);
        const Together lower = share / (term.damping * term.damping + above * above);
        const Together upper_imaginary = -below * upper;
        const Together lower_imaginary = -above * lower;
        const Together real_sum = term.damping * (upper + lower);
        const Together real_difference = term.damping * (upper - lower);
        const Together imaginary_sum = upper_imaginary + lower_imaginary;
        const Together imaginary_difference = upper_imaginary - lower_imaginary;
        for (std::size_t c = 0; c < kParts / 2; ++c) {
            sum[2 * c] += term.real[c] * real_sum - term.imaginary[c] * imaginary_difference;
            sum[2 * c + 1] += term.real[c] * imaginary_sum + term.imaginary[c] * real_difference;
        }
    }
    std::memcpy(sums, sum, sizeof sum);
}

/// Poles below this wave number in 1/m, of 5 Hz, are those of the constant pressure: two octaves
/// below what is heard, where rooms of up to 30 m have no other modes.
constexpr double kConstantPressure = 0.1;

bool is_constant(const Complex& pole) { return std::abs(pole) < kConstantPressure; }

/// The poles of the constant pressure.
WaveResponse::Octaves constant_of(const WaveResponse::Octaves& octaves) {
    WaveResponse::Octaves constant;
    for (std::size_t i = 0; i < octaves.poles.size(); ++i) {
        if (!is_constant(octaves.poles[i])) continue;
        constant.poles.push_back(octaves.poles[i]);
        constant.residues.push_back(octaves.residues[i]);
    }
    return constant;
}

/// All other poles.
std::vector<PoleTerm> terms_of(const WaveResponse::Octaves& octaves, double shift) {
    std::vector<PoleTerm> terms;
    for (std::size_t i = 0; i < octaves.poles.size(); ++i) {
        const Complex pole = octaves.poles[i];
        if (is_constant(pole)) continue;
        // A real pole is its own conjugate.
        const float factor = pole.imag() == 0 ? 0.5F : 1.0F;
        PoleTerm& term = terms.emplace_back();
        term.damping = static_cast<float>(shift - pole.real());
        term.wave_number = static_cast<float>(pole.imag());
        for (std::size_t c = 0; c < kParts / 2; ++c) {
            const Complex residue = octaves.residues[i][c];
            term.real[c] = factor * static_cast<float>(residue.real());
            term.imaginary[c] = factor * static_cast<float>(residue.imag());
        }
    }
    return terms;
}

double share_of(const WaveResponse::Octaves& octaves, double wave_number) {
    return octave_share(octaves.begin, octaves.end, wave_number);
}

}  // namespace

double octave_share(double begin, double end, double wave_number) {
    return share_above(wave_number / begin) - share_above(wave_number / end);
}

WaveSpectra WaveResponse::modal(double step, std::size_t count, double shift) const {
    WaveSpectra spectra;
    for (auto& spectrum : spectra) spectrum.assign(count, 0);
    for (const Octaves& some : octaves) {
        const std::vector<PoleTerm> terms = terms_of(some, shift);
        for (std::size_t first = 0; first < count; first += kTogether) {
            std::array<float, kTogether> at{};
            std::array<float, kTogether> shares{};
            const std::size_t end = std::min(kTogether, count - first);
            for (std::size_t i = 0; i < end; ++i) {
                const double wave_number = static_cast<double>(first + i) * step;
                at[i] = static_cast<float>(wave_number);
                if (wave_number > 0) shares[i] = static_cast<float>(share_of(some, wave_number));
            }
            if (std::all_of(shares.begin(), shares.end(), [](float x) { return x == 0; })) continue;
            std::array<float, kParts * kTogether> sums{};
            best_version<add_poles>(terms.data(), terms.size(), at.data(), shares.data(),
                                    sums.data());
            for (std::size_t c = 0; c < spectra.size(); ++c)
                for (std::size_t i = 0; i < end; ++i)
                    spectra[c][first + i] += std::complex<float>(sums[2 * c * kTogether + i],
                                                                 sums[(2 * c + 1) * kTogether + i]);
        }
        const Octaves constant = constant_of(some);
        for (std::size_t i = 1; i < count && !constant.poles.empty(); ++i) {
            const double wave_number = static_cast<double>(i) * step;
            const double share = share_of(some, wave_number);
            if (share == 0) continue;
            WaveField field{};
            add_field(constant, {shift, wave_number}, share, field);
            for (std::size_t c = 0; c < spectra.size(); ++c) spectra[c][i] += field[c];
        }
    }
    return spectra;
}

WaveField WaveResponse::modal(double wave_number) const {
    WaveField sum{};
    for (const Octaves& some : octaves) {
        const double share = share_of(some, wave_number);
        if (share > 0) add_field(some, {0, wave_number}, share, sum);
    }
    return sum;
}

WaveField WaveResponse::reverberant(double wave_number) const {
    WaveField field = modal(wave_number);
    const double distance_m{glm::length(from_source)};
    const auto direct = direct_field(distance_m, {0, wave_number});
    const auto beyond = direct_field_beyond(distance_m, wave_number, highest_wave_number);
    field[0] -= direct[0] - beyond[0];
    const Vec3 along = near_direction(from_source);
    for (std::size_t a = 0; a < 3; ++a) {
        field[a + 1] -= (direct[1] - beyond[1]) * double{along[static_cast<int>(a)]};
    }
    return field;
}

WaveResponse wave_response(const RoomModes& modes, std::span<const OctavePoles> octaves,
                           const ModeValues& source, const ModeValues& receiver) {
    WaveResponse response;
    response.highest_wave_number = modes.highest_wave_number;
    response.from_source = receiver.place - source.place;
    for (const OctavePoles& some : octaves) {
        WaveResponse::Octaves& result = response.octaves.emplace_back();
        result.begin = some.begin;
        result.end = some.end;
        for (const DampedPole& pole : some.poles) {
            Complex sent = 0;
            WaveField received{};
            for (std::size_t m = 0; m < modes.count(); ++m) {
                sent += pole.shape[m] * source.pressure[m];
                received[0] += pole.shape[m] * receiver.pressure[m];
                for (std::size_t a = 0; a < 3; ++a) {
                    received[a + 1] += pole.shape[m] * receiver.slope[m][a];
                }
            }
            for (Complex& r : received) r *= 4 * std::numbers::pi * sent;
            result.poles.push_back(pole.pole);
            result.residues.push_back(received);
        }
    }
    return response;
}

std::array<Complex, 2> direct_field(double distance_m, Complex s) {
    const double r = std::max(distance_m, kNearest_m);
    const Complex value = std::exp(-s * r) / r;
    return {value, -value * (1 / r + s)};
}

std::array<double, 2> direct_field_beyond(double distance_m, double wave_number, double highest) {
    const double r = std::max(distance_m, kNearest_m);
    const double k = wave_number;
    // From one wave number K on, with a = (K - k) r and b = (K + k) r, the value is
    // (cos(k r) (pi - Si(a) - Si(b)) + sin(k r) (Ci(b) - Ci(a))) / (pi r).
    const double lowest = (1 - kModeTaper) * highest;
    const MeanIntegrals a((lowest - k) * r, (highest - k) * r);
    const MeanIntegrals b((lowest + k) * r, (highest + k) * r);
    const double sines = std::numbers::pi - a.sine_integral - b.sine_integral;
    const double cosines = b.cosine_integral - a.cosine_integral;
    const double c = std::cos(k * r);
    const double s = std::sin(k * r);
    const double value = (c * sines + s * cosines) / (std::numbers::pi * r);
    const double slope = (-k * s * sines - c * (a.sine + b.sine) / r + k * c * cosines +
                          s * (b.cosine - a.cosine) / r) /
                         (std::numbers::pi * r);
    return {value, slope - value / r};
}

std::array<double, 2> sine_cosine_integrals(double x) {
    if (x < kSeriesEnd) {
        double sine = 0;
        double cosine = 0;
        double power = 1;  // (-1)^(n / 2) x^n / n!
        for (int n = 1; n <= kSeriesTerms; ++n) {
            power *= x / n;
            if (n % 2 == 0) power = -power;
            (n % 2 == 1 ? sine : cosine) += power / n;
        }
        return {sine, std::numbers::egamma + std::log(x) + cosine};
    }
    // The continued fraction of E1(j x) = -Ci(x) + j (Si(x) - pi / 2), by Lentz's method.
    Complex b(1, x);
    Complex c = 1 / std::numeric_limits<double>::min();
    Complex d = 1.0 / b;
    Complex fraction = d;
    for (int i = 1; i <= kFractionTerms; ++i) {
        const double a = -static_cast<double>(i) * i;
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        const Complex step = c * d;
        fraction *= step;
        if (std::abs(step - 1.0) < kExact) break;
    }
    const Complex integral = fraction * std::polar(1.0, -x);
    return {std::numbers::pi / 2 + integral.imag(), -integral.real()};
}

}  // namespace aula
