#include "engine/response/third_octave_model.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "aula/engine/third_octaves.h"
#include "engine/scene/air.h"

using namespace aula;

namespace {

double surfaces(double octave) { return std::exp(-0.4 * octave - 1); }

/// The energy of a frequency after a distance.
double exact(const Medium& medium, double frequency_hz, double length_m) {
    const double octave = std::clamp(std::log10(frequency_hz / 1000) / 0.3 + 4, 0.0, 7.0);
    return surfaces(octave) * std::exp(-air_attenuation_per_m(medium, frequency_hz) * length_m);
}

Bands octaves_after(const Medium& medium, double length_m) {
    const Bands air = medium.attenuation_per_m();
    Bands octaves;
    for (std::size_t b = 0; b < kBandCount; ++b)
        octaves[b] = static_cast<float>(surfaces(static_cast<double>(b)) *
                                        std::exp(-double{air[b]} * length_m));
    return octaves;
}

}  // namespace

TEST_CASE("third octaves have exact air, and surfaces in dB between those of octaves") {
    const Medium medium{.temperature_c = 5, .humidity_percent = 30};
    const ThirdOctaveModel model(medium);
    for (const double length_m : {0.0, 30.0, 300.0}) {
        const ThirdOctaveModel::Values energies =
            model.at_centres(octaves_after(medium, length_m), length_m);
        for (std::size_t t = 0; t < ThirdOctaveModel::kCount; ++t) {
            CAPTURE(length_m, t);
            // Rounding of the exponent, of up to 40.
            CHECK(double{energies[t]} ==
                  Approx(exact(medium, ThirdOctaveModel::centre_hz(t), length_m)).epsilon(1e-5));
        }
    }
    // Companion: the air of the octave is another one at 16 kHz.
    CHECK(air_attenuation_per_m(medium, ThirdOctaveModel::centre_hz(25)) >
          1.2 * air_attenuation_per_m(medium, ThirdOctaveModel::centre_hz(22)));
}

TEST_CASE("the energy of a third octave is the mean over it") {
    const Medium medium;
    const ThirdOctaveModel model(medium);
    for (const double length_m : {0.0, 30.0, 100.0}) {
        const Bands octaves = octaves_after(medium, length_m);
        const ThirdOctaveModel::Values energies = model.energies(octaves, length_m);
        double largest = 1;
        for (std::size_t t = 0; t < kThirdOctaveCount; ++t) {
            const double centre_hz = ThirdOctaveModel::centre_hz(t);
            constexpr int kPoints = 200;
            double mean = 0;
            for (int i = 0; i < kPoints; ++i)
                mean += exact(medium, centre_hz * std::pow(10, ((i + 0.5) / kPoints - 0.5) / 10),
                              length_m) /
                        double{kPoints};
            largest = std::max(largest, mean / exact(medium, centre_hz, length_m));
            CAPTURE(length_m, t);
            // The level curves: by 0.3 dB at 16 kHz after 100 m.
            CHECK(double{energies[t]} == Approx(mean).epsilon(length_m < 100 ? 0.025 : 0.08));
        }
        // Companion: the centre has less energy.
        CHECK((largest > 1.2) == (length_m == 100));
    }
}

TEST_CASE("beside a silent octave third octaves are silent up to the next centre") {
    const ThirdOctaveModel model(Medium{});
    Bands octaves = Bands::filled(1);
    octaves[3] = 0;
    const ThirdOctaveModel::Values energies = model.energies(octaves, 1);
    const ThirdOctaveModel::Values at_centres = model.at_centres(octaves, 1);
    for (std::size_t t = 0; t < ThirdOctaveModel::kCount; ++t) {
        CAPTURE(t);
        CHECK((energies[t] == 0) == (t > 7 && t < 13));
        CHECK((at_centres[t] == 0) == (t > 7 && t < 13));
    }
}

TEST_CASE("names and centres of third octaves are those of IEC 61260-1") {
    for (std::size_t t = 0; t < kThirdOctaveCount; ++t) {
        CHECK(ThirdOctaveModel::centre_hz(t) ==
              Approx(std::stod(third_octave_name(t))).epsilon(0.015));
        const double octave_hz = double{kBandCentres_hz[ThirdOctaveModel::octave(t)]};
        CHECK((std::abs(std::log2(ThirdOctaveModel::centre_hz(t) / octave_hz)) < 0.4 || t > 23));
    }
}
