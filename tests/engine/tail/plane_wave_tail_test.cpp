// The tail as a field in space: plane waves at the listener's place.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
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
        static std::map<double, std::shared_ptr<const NoiseCarriers>> made;
        auto& carriers = made[rate_hz];
        if (!carriers) carriers = make_noise_carriers(rate_hz, 1);
        return carriers;
    }

    ImpulseResponseBuilder builder_;
    EnergyResponse energy_;
    ImpulseResponse response_;
};

/// Part of a tail from 0.3 s on, in a band.
std::vector<double> late(const std::vector<float>& tail, const FrequencyBand& band,
                         double rate_hz = kLowRate_hz) {
    const std::vector<double> x = band_passed(tail, rate_hz, band, 0);
    return {x.begin() + static_cast<std::ptrdiff_t>(0.3 * rate_hz), x.end()};
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return sum;
}

/// The correlation of the tails at two places in a band: its mean over sources, each with another
/// direction from place to place.
double correlation(double distance_m, const FrequencyBand& band, int sources) {
    double both = 0;
    double each = 0;
    for (int s = 0; s < sources; ++s) {
        Field field(std::to_string(s));
        const Vec3 direction = wave_directions(static_cast<std::uint64_t>(s))[0];
        const auto a = late(field.tail(Vec3(1, 2, 1.5F)), band);
        const auto b =
            late(field.tail(Vec3(1, 2, 1.5F) + static_cast<float>(distance_m) * direction), band);
        both += product(a, b);
        each += std::sqrt(product(a, a) * product(b, b));
    }
    return both / each;
}

/// The mean of sin(kd) / (kd) over a band.
double diffuse(double distance_m, const FrequencyBand& band) {
    constexpr int kSteps = 200;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double hz = band.low_hz + band.width_hz() * (i + 0.5) / kSteps;
        const double kd = 2 * std::numbers::pi * hz / kSpeed_m_s * distance_m;
        sum += std::sin(kd) / kd / kSteps;
    }
    return sum;
}

std::complex<double> tone(const std::vector<float>& tail, double frequency_hz,
                          double rate_hz = kLowRate_hz) {
    std::complex<double> sum;
    const auto turn = std::polar(1.0, -2 * std::numbers::pi * frequency_hz / rate_hz);
    std::complex<double> phase = 1;
    for (const float x : tail) {
        sum += double{x} * phase;
        phase *= turn;
    }
    return sum;
}

/// The standard deviation of the level of tones over 40 places in 8 fields. Places are half a
/// wavelength of the first tone apart and therefore independent.
double deviation_on_walk_db(const std::vector<double>& tones_hz, double rate_hz = kLowRate_hz) {
    constexpr int kSources = 8;
    constexpr int kSteps = 40;
    const auto step_m = static_cast<float>(kSpeed_m_s / tones_hz[0] / 2);
    double square = 0;
    for (int s = 0; s < kSources; ++s) {
        Field field(std::to_string(s), rate_hz);
        std::vector<std::array<double, kSteps>> levels_db(tones_hz.size());
        for (std::size_t i = 0; i < kSteps; ++i) {
            const std::vector<float>& tail =
                field.tail(Vec3(0, step_m * static_cast<float>(i), 1.5F));
            for (std::size_t t = 0; t < tones_hz.size(); ++t)
                levels_db[t][i] = db(std::norm(tone(tail, tones_hz[t], rate_hz)));
        }
        for (const auto& of_tone : levels_db) {
            double mean_db = 0;
            for (const double x : of_tone) mean_db += x / kSteps;
            for (const double x : of_tone) square += (x - mean_db) * (x - mean_db) / (kSteps - 1);
        }
    }
    return std::sqrt(square / (kSources * static_cast<double>(tones_hz.size())));
}

/// The shifts of a tone's frequency along walks, in units of the largest one, f v / c.
struct DopplerSpread {
    double deviation = 0;   ///< standard deviation
    double lower_half = 0;  ///< share of the energy with less than half of the largest shift
    double beyond = 0;      ///< share of the energy beyond the largest one
};

DopplerSpread doppler_spread(double frequency_hz) {
    constexpr int kSources = 16;
    constexpr int kSteps = 96;
    constexpr double kPerWavelength = 6;
    const auto step_m = static_cast<float>(kSpeed_m_s / frequency_hz / kPerWavelength);
    // The main lobe of the window.
    constexpr double kResolution = 2 * kPerWavelength / kSteps;
    double all = 0;
    DopplerSpread spread;
    for (int s = 0; s < kSources; ++s) {
        Field field(std::to_string(s));
        std::array<std::complex<double>, kSteps> walk{};
        for (std::size_t i = 0; i < kSteps; ++i) {
            const double window =
                1 - std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kSteps);
            walk[i] = window *
                      tone(field.tail(Vec3(0, step_m * static_cast<float>(i), 1.5F)), frequency_hz);
        }
        for (int k = -kSteps / 2; k < kSteps / 2; ++k) {
            std::complex<double> sum;
            for (int i = 0; i < kSteps; ++i)
                sum += walk[static_cast<std::size_t>(i)] *
                       std::polar(1.0, -2 * std::numbers::pi * k * i / kSteps);
            const double shift = k * kPerWavelength / kSteps;
            const double energy = std::norm(sum);
            all += energy;
            spread.deviation += energy * shift * shift;
            if (std::abs(shift) < 0.5) spread.lower_half += energy;
            if (std::abs(shift) > 1 + kResolution) spread.beyond += energy;
        }
    }
    return {std::sqrt(spread.deviation / all), spread.lower_half / all, spread.beyond / all};
}

/// Fourth moment, and standard deviation of the short-time level, of noises in a band.
struct NoiseStatistics {
    double kurtosis = 0;
    double deviation_db = 0;
};

template <typename Noise>
NoiseStatistics statistics_of(const FrequencyBand& band, double window_s, const Noise& noise) {
    constexpr int kNoises = 30;
    const auto width = static_cast<std::size_t>(window_s * kRate_hz);
    NoiseStatistics found;
    int windows = 0;
    double sum = 0;
    double square = 0;
    for (int s = 0; s < kNoises; ++s) {
        const std::vector<double> x = noise(s, band);
        const double power = product(x, x) / static_cast<double>(x.size());
        for (const double v : x)
            found.kurtosis +=
                v * v * v * v / (power * power) / kNoises / static_cast<double>(x.size());
        for (std::size_t n = 0; n + width <= x.size(); n += width, ++windows) {
            double energy = 0;
            for (std::size_t k = n; k < n + width; ++k) energy += x[k] * x[k];
            sum += db(energy);
            square += db(energy) * db(energy);
        }
    }
    const double mean = sum / windows;
    found.deviation_db = std::sqrt(square / windows - mean * mean);
    return found;
}

/// A tail that does not decay, in a band.
std::vector<double> steady_tail(int source, const FrequencyBand& band) {
    ImpulseResponse ir;
    ImpulseResponseBuilder(carriers(1), kNoAir, kLength_s, std::to_string(source), 0)
        .build(decay(kLength_s, all(1e6), all(1)), ir);
    return late(ir.channels[0], band, kRate_hz);
}

/// Noise that is nearly Gaussian, in a band.
std::vector<double> gaussian(int seed, const FrequencyBand& band) {
    std::srand(static_cast<unsigned>(seed + 1));
    std::vector<float> noise(static_cast<std::size_t>(kLength_s * kRate_hz));
    for (float& x : noise)
        for (int i = 0; i < 4; ++i)
            x += static_cast<float>(std::rand()) / static_cast<float>(RAND_MAX) - 0.5F;
    return late(noise, band, kRate_hz);
}

/// The same with constant power over 8 independent samples.
std::vector<double> levelled(int seed, const FrequencyBand& band) {
    const std::vector<double> x = gaussian(seed, band);
    const auto half = static_cast<std::size_t>(4 * kRate_hz / (2 * band.width_hz()));
    std::vector<double> level(x.size());
    for (std::size_t n = half; n + half < x.size(); ++n) {
        double energy = 0;
        for (std::size_t k = n - half; k <= n + half; ++k) energy += x[k] * x[k];
        level[n] = x[n] / std::sqrt(energy);
    }
    return {level.begin() + static_cast<std::ptrdiff_t>(half),
            level.end() - static_cast<std::ptrdiff_t>(half)};
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
    // Statistical, fixed seeds: the late tail has about 2 B T / 13.8 = 19 independent samples in
    // the octave of 125 Hz, and 70 or more from 1 kHz on.
    const FrequencyBand highest{1190, 1500};
    for (const auto& [band, sources] :
         {std::pair(FrequencyBand::at(-3, 1), 60), std::pair(FrequencyBand::at(-2, 1), 40),
          std::pair(FrequencyBand::at(-1, 1), 25), std::pair(FrequencyBand::at(0, 1), 25),
          std::pair(highest, 25)}) {
        for (const double distance_m : {0.1, 0.3, 1.0, 15.0}) {
            CAPTURE(band.low_hz, distance_m);
            CHECK(correlation(distance_m, band, sources) ==
                  Approx(diffuse(distance_m, band)).margin(0.1));
        }
    }
    // Companion: carriers that do not move.
    CHECK(correlation(15, {2240, 2820}, 1) > 0.99);
}

TEST_CASE("the level of a tone varies along a walk as in a diffuse field") {
    // The energy of a tone in a diffuse field is exponentially distributed: 5.57 dB. Statistical,
    // fixed seeds: 320 places, 6 %.
    for (const double hz : {100.0, 315.0, 800.0, 1250.0, 1500.0}) {
        CAPTURE(hz);
        const double deviation_db = deviation_on_walk_db({hz});
        CHECK(deviation_db > 5.0);
        CHECK(deviation_db < 6.1);
    }
    // Companion: the carriers from 2 kHz on do not move.
    CHECK(deviation_on_walk_db({2300}) < 0.5);
}

TEST_CASE("the level of a tone varies along a walk at every sample rate") {
    // Statistical, fixed seeds: 320 places, three tones, 4 %.
    for (const double rate_hz : {16000.0, 32000.0, 44100.0, 48000.0, 96000.0}) {
        CAPTURE(rate_hz);
        const double deviation_db = deviation_on_walk_db({1400, 1450, 1500}, rate_hz);
        CHECK(deviation_db > 5.0);
        CHECK(deviation_db < 6.1);
    }
}

TEST_CASE("the Doppler spread of a tone along a walk is that of a diffuse field") {
    // Shifts are uniform from -f v / c to f v / c. Statistical, fixed seeds: 16 walks of 16
    // wavelengths, 260 independent energies or more: 3 % of the deviation, 0.03 of the shares.
    for (const double hz : {125.0, 1500.0}) {
        const DopplerSpread spread = doppler_spread(hz);
        CAPTURE(hz, spread.deviation, spread.lower_half, spread.beyond);
        CHECK(spread.deviation == Approx(1 / std::sqrt(3.0)).epsilon(0.1));
        // Waves in one plane would have a third.
        CHECK(spread.lower_half == Approx(0.5).margin(0.08));
        CHECK(spread.beyond < 0.01);
    }
    // Companion: carriers that do not move.
    CHECK(doppler_spread(2300).deviation < 0.1);
}

TEST_CASE("tails differ from room to room and not with the order of rendering") {
    Field one("source1", kLowRate_hz, 1);
    Field two("source1", kLowRate_hz, 2);
    const std::vector<float> first = one.tail(Vec3(1, 2, 3));
    one.tail(Vec3(5, 2, 3));
    CHECK(one.tail(Vec3(1, 2, 3)) == first);  // a listener at rest hears no change
    const auto a = late(first, FrequencyBand::at(-1, 1));
    const auto b = late(two.tail(Vec3(1, 2, 3)), FrequencyBand::at(-1, 1));
    // Statistical: 38 independent samples, 0.16.
    CHECK(std::abs(product(a, b)) < 0.4 * std::sqrt(product(a, a) * product(b, b)));
}

TEST_CASE("the tail has the distribution and the short-time level of Gaussian noise") {
    // In windows of W independent samples the level of Gaussian noise deviates by
    // 10 lg e sqrt(psi'(W / 2)) dB; here by comparison with noise in the same windows.
    for (const auto& [octave, window_s] :
         {std::pair(-2, 0.04), std::pair(0, 0.01), std::pair(1, 0.007), std::pair(2, 0.005)}) {
        const FrequencyBand band = FrequencyBand::at(octave, 1);
        const NoiseStatistics tail = statistics_of(band, window_s, steady_tail);
        const NoiseStatistics noise = statistics_of(band, window_s, gaussian);
        CAPTURE(octave, tail.deviation_db, noise.deviation_db, tail.kurtosis);
        CHECK(tail.kurtosis == Approx(3).epsilon(0.1));
        // Statistical, fixed seeds: 900 windows or more, 2.4 %.
        CHECK(tail.deviation_db == Approx(noise.deviation_db).epsilon(0.1));
        // Companion: noise of constant power over 8 independent samples.
        const NoiseStatistics even = statistics_of(band, window_s, levelled);
        CHECK(even.kurtosis < 2.7);
        CHECK(even.deviation_db < 0.9 * noise.deviation_db);
    }
}

}  // namespace plane_wave_tail_test
