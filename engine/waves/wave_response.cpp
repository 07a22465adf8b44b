#include "engine/waves/wave_response.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "engine/base/near_field.h"

namespace aula {

namespace {

using Complex = std::complex<double>;

/// Below this argument the series of the integrals of sine and cosine converges faster than the
/// continued fraction.
constexpr double kSeriesEnd = 3;

/// 0..1: the part above an edge, at a ratio of wave numbers to it.
double share_above(double ratio) {
    return std::clamp(0.5 + std::log2(ratio) / kOctaveFade, 0.0, 1.0);
}

/// Adds poles and their residues, with the share of the octaves.
void add_field(const WaveResponse::Octaves& octaves, double wave_number, double share,
               WaveField& sum) {
    const Complex s(0, wave_number);
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

}  // namespace

WaveField WaveResponse::modal(double wave_number) const {
    WaveField sum{};
    for (const Octaves& some : octaves) {
        const double share =
            share_above(wave_number / some.begin) - share_above(wave_number / some.end);
        if (share > 0) add_field(some, wave_number, share, sum);
    }
    return sum;
}

WaveField WaveResponse::reverberant(double wave_number) const {
    WaveField field = modal(wave_number);
    const double distance_m{glm::length(from_source)};
    const auto direct = direct_field(distance_m, wave_number);
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

std::array<Complex, 2> direct_field(double distance_m, double wave_number) {
    const double r = std::max(distance_m, kNearest_m);
    const Complex value = std::polar(1 / r, -wave_number * r);
    return {value, -value * Complex(1 / r, wave_number)};
}

std::array<double, 2> direct_field_beyond(double distance_m, double wave_number, double highest) {
    const double r = std::max(distance_m, kNearest_m);
    const double k = wave_number;
    const double a = (highest - k) * r;
    const double b = (highest + k) * r;
    const auto [sine_a, cosine_a] = sine_cosine_integrals(a);
    const auto [sine_b, cosine_b] = sine_cosine_integrals(b);
    const double sines = std::numbers::pi - sine_a - sine_b;
    const double cosines = cosine_b - cosine_a;
    const double c = std::cos(k * r);
    const double s = std::sin(k * r);
    const double value = (c * sines + s * cosines) / (std::numbers::pi * r);
    const double slope = (-k * s * sines - c * (std::sin(a) + std::sin(b)) / r + k * c * cosines +
                          s * (std::cos(b) - std::cos(a)) / r) /
                         (std::numbers::pi * r);
    return {value, slope - value / r};
}

std::array<double, 2> sine_cosine_integrals(double x) {
    if (x < kSeriesEnd) {
        double sine = 0;
        double cosine = 0;
        double power = 1;  // (-1)^(n / 2) x^n / n!
        for (int n = 1; n < 40; ++n) {
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
    for (int i = 1; i < 200; ++i) {
        const double a = -static_cast<double>(i) * i;
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        const Complex step = c * d;
        fraction *= step;
        if (std::abs(step - 1.0) < 1e-15) break;
    }
    const Complex integral = fraction * std::polar(1.0, -x);
    return {std::numbers::pi / 2 + integral.imag(), -integral.real()};
}

}  // namespace aula
