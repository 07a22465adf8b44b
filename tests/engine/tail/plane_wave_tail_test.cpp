// The tail as a field in space: plane waves at the listener's place.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "engine/base/spherical_harmonics.h"
#include "engine/response/band_pass.h"
#include "engine/tail/wave_directions.h"
#include "tests/engine/tail/response_building.h"

namespace plane_wave_tail_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kSpeed_m_s = 343.2;
constexpr double kLength_s = 1.5;
constexpr double kLowRate_hz = 8000;

/// Tails of a source at any place of a diffuse field of 1.5 s.
class Field {
 public:
    explicit Field(const std::string& source, double rate_hz = kLowRate_hz, std::uint64_t room = 0)
        : builder_(carriers_of(rate_hz), kNoAir, kLength_s, source, 0),
          energy_(decay(kLength_s, all(1.5), all(1))) {
        energy_.room = room;
    }

    const std::vector<float>& tail(const Vec3& place) {
        energy_.listener = place;
        builder_.build(energy_, response_);
        return response_.channels[0];
    }

 private:
    static std::shared_ptr<const NoiseCarriers> carriers_of(double rate_hz) {
        static const auto low = make_noise_carriers(kLowRate_hz, 1);
        return rate_hz == kLowRate_hz ? low : carriers(1);
    }

    ImpulseResponseBuilder builder_;
    EnergyResponse energy_;
    ImpulseResponse response_;
};

/// Part of a tail from 0.3 s on, in an octave.
std::vector<double> late(const std::vector<float>& tail, int octave, double rate_hz = kLowRate_hz) {
    const std::vector<double> x = band_passed(tail, rate_hz, FrequencyBand::at(octave, 1), 0);
    return {x.begin() + static_cast<std::ptrdiff_t>(0.3 * rate_hz), x.end()};
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return sum;
}

/// Directions of displacement, and the correlation of the tails in an octave, as their mean over
/// many sources.
double correlation(double distance_m, int octave, int sources) {
    double both = 0;
    double each = 0;
    for (int s = 0; s < sources; ++s) {
        Field field(std::to_string(s));
        const Vec3 direction = wave_directions(static_cast<std::uint64_t>(s))[0];
        const auto a = late(field.tail(Vec3(1, 2, 1.5F)), octave);
        const auto b =
            late(field.tail(Vec3(1, 2, 1.5F) + static_cast<float>(distance_m) * direction), octave);
        both += product(a, b);
        each += std::sqrt(product(a, a) * product(b, b));
    }
    return both / each;
}

/// The mean of sin(kd) / (kd) over an octave.
double diffuse(double distance_m, int octave) {
    constexpr int kSteps = 200;
    double sum = 0;
    double width = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double hz = 1000 * std::exp2(octave - 0.5 + (i + 0.5) / kSteps);
        const double kd = 2 * std::numbers::pi * hz / kSpeed_m_s * distance_m;
        sum += hz * std::sin(kd) / kd;
        width += hz;
    }
    return sum / width;
}

std::complex<double> tone(const std::vector<float>& tail, double frequency_hz) {
    std::complex<double> sum;
    const auto turn = std::polar(1.0, -2 * std::numbers::pi * frequency_hz / kLowRate_hz);
    std::complex<double> phase = 1;
    for (const float x : tail) {
        sum += double{x} * phase;
        phase *= turn;
    }
    return sum;
}

}  // namespace

TEST_CASE(
    "the directions of plane waves make harmonics orthogonal, half of them those of order 1") {
    for (const std::uint64_t seed : {1UL, 2UL, 3UL}) {
        const auto directions = wave_directions(seed);
        std::array<std::array<double, 16>, 16> sum{};
        for (const Vec3& u : directions) {
            std::array<double, 16> y{};
            spherical_harmonics(u, 3, y.data());
            for (std::size_t i = 0; i < 16; ++i)
                for (std::size_t j = 0; j < 16; ++j) sum[i][j] += y[i] * y[j] / double{kPlaneWaves};
        }
        std::array<std::array<double, 4>, 4> half{};
        for (std::size_t w = 0; w < plane_waves(1); ++w) {
            std::array<double, 4> y{};
            spherical_harmonics(directions[w], 1, y.data());
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t j = 0; j < 4; ++j)
                    half[i][j] += y[i] * y[j] / static_cast<double>(plane_waves(1));
        }
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j)
                CHECK(half[i][j] == Approx(i != j ? 0 : i == 0 ? 1 : 1.0 / 3).margin(2e-6));
        for (std::size_t i = 0; i < 16; ++i)
            for (std::size_t j = 0; j < 16; ++j)
                // Rounding of directions in single precision.
                CHECK(sum[i][j] ==
                      Approx(i == j ? 1 / (2 * std::floor(std::sqrt(double(i))) + 1) : 0)
                          .margin(2e-6));
    }
    CHECK(wave_directions(1) != wave_directions(2));
}

TEST_CASE("the tails at two places correlate as in a diffuse field") {
    // Statistical, fixed seeds: the late tail has about 2 B T / 13.8 = 9 independent samples in the
    // octave of 125 Hz, and 75 in that of 1 kHz.
    for (const auto& [octave, sources] : {std::pair(-3, 60), std::pair(-1, 25), std::pair(0, 25)}) {
        for (const double distance_m : {0.1, 0.3, 1.0, 15.0}) {
            CAPTURE(octave, distance_m);
            CHECK(correlation(distance_m, octave, sources) ==
                  Approx(diffuse(distance_m, octave)).margin(0.1));
        }
    }
    // Companion: carriers that do not move.
    Field field("source", kRate_hz);
    const auto here = late(field.tail(Vec3(0)), 2, kRate_hz);
    const auto there = late(field.tail(Vec3(15, 0, 0)), 2, kRate_hz);
    CHECK(product(here, there) / std::sqrt(product(here, here) * product(there, there)) > 0.99);
}

TEST_CASE("the level of a tone varies along a walk as in a diffuse field") {
    constexpr int kSources = 8;
    constexpr int kSteps = 40;
    for (const double hz : {100.0, 315.0, 1250.0}) {
        double square = 0;
        double change = 0;
        double power = 0;
        for (int s = 0; s < kSources; ++s) {
            Field field(std::to_string(s));
            // Half a wavelength apart: independent places. A tenth of a wavelength beside each.
            const auto step_m = static_cast<float>(kSpeed_m_s / hz / 2);
            std::array<double, kSteps> level_db{};
            double mean_db = 0;
            for (int i = 0; i < kSteps; ++i) {
                const Vec3 place(0, step_m * static_cast<float>(i), 1.5F);
                const auto here = tone(field.tail(place), hz);
                level_db[static_cast<std::size_t>(i)] = db(std::norm(here));
                mean_db += db(std::norm(here)) / kSteps;
                change += std::norm(tone(field.tail(place + Vec3(0, 0.2F * step_m, 0)), hz) - here);
                power += std::norm(here);
            }
            for (const double x : level_db)
                square += (x - mean_db) * (x - mean_db) / (kSteps - 1) / kSources;
        }
        CAPTURE(hz, std::sqrt(square), change / power);
        // The energy of a tone in a diffuse field is exponentially distributed: 5.57 dB. Carriers
        // that do not move have 0.
        CHECK(std::sqrt(square) > 5.0);
        CHECK(std::sqrt(square) < 6.1);
        // The Doppler spread: over a distance d the pressure changes by |p(d) - p|^2 =
        // 2 (1 - sin(kd) / (kd)) |p|^2. Statistical: 320 places, 8 %; thrice that.
        const double kd = 2 * std::numbers::pi / 10;
        CHECK(change / power == Approx(2 * (1 - std::sin(kd) / kd)).epsilon(0.25));
    }
}

TEST_CASE("tails differ from room to room and not with the order of rendering") {
    Field one("source1", kLowRate_hz, 1);
    Field two("source1", kLowRate_hz, 2);
    const std::vector<float> first = one.tail(Vec3(1, 2, 3));
    one.tail(Vec3(5, 2, 3));
    CHECK(one.tail(Vec3(1, 2, 3)) == first);  // a listener at rest hears no change
    const auto a = late(first, -1);
    const auto b = late(two.tail(Vec3(1, 2, 3)), -1);
    // Statistical: 38 independent samples, 0.16.
    CHECK(std::abs(product(a, b)) < 0.4 * std::sqrt(product(a, a) * product(b, b)));
}

TEST_CASE("the tail has the distribution and the short-time level of Gaussian noise") {
    // In windows of W independent samples the level of Gaussian noise deviates by
    // 10 lg e sqrt(psi'(W / 2)) dB; here by comparison with noise in the same windows.
    for (const auto& [octave, window_s] :
         {std::pair(-2, 0.04), std::pair(0, 0.01), std::pair(2, 0.005)}) {
        std::array<double, 2> deviation_db{};
        std::array<double, 2> kurtosis{};
        for (const bool is_gaussian : {false, true}) {
            double fourth = 0;
            int windows = 0;
            double sum = 0;
            double square = 0;
            for (int s = 0; s < 30; ++s) {
                std::vector<float> tail;
                if (is_gaussian) {
                    std::srand(static_cast<unsigned>(s + 1));
                    tail.resize(static_cast<std::size_t>(kLength_s * kRate_hz));
                    for (float& x : tail)
                        for (int i = 0; i < 4; ++i)
                            x += static_cast<float>(std::rand()) / static_cast<float>(RAND_MAX) -
                                 0.5F;
                } else {
                    ImpulseResponse ir;
                    ImpulseResponseBuilder(carriers(1), kNoAir, kLength_s, std::to_string(s), 0)
                        .build(decay(kLength_s, all(1e6), all(1)), ir);
                    tail = ir.channels[0];
                }
                const auto x = late(tail, octave, kRate_hz);
                const double power = product(x, x) / static_cast<double>(x.size());
                for (const double v : x)
                    fourth += v * v * v * v / (power * power) / 30 / static_cast<double>(x.size());
                const auto width = static_cast<std::size_t>(window_s * kRate_hz);
                for (std::size_t n = 0; n + width <= x.size(); n += width, ++windows) {
                    double energy = 0;
                    for (std::size_t k = n; k < n + width; ++k) energy += x[k] * x[k];
                    sum += db(energy);
                    square += db(energy) * db(energy);
                }
            }
            const std::size_t i = is_gaussian ? 1 : 0;
            const double mean = sum / windows;
            deviation_db[i] = std::sqrt(square / windows - mean * mean);
            kurtosis[i] = fourth;
        }
        CAPTURE(octave, deviation_db[0], deviation_db[1], kurtosis[0]);
        CHECK(kurtosis[0] == Approx(3).epsilon(0.1));
        // Statistical, fixed seeds: 900 windows or more, 2.4 %.
        CHECK(deviation_db[0] == Approx(deviation_db[1]).epsilon(0.1));
    }
}

}  // namespace plane_wave_tail_test
