#include "engine/response/third_octave_model.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "aula/engine/third_octaves.h"
#include "engine/scene/air.h"

using namespace aula;

TEST_CASE("third octaves have exact air, and surfaces in dB between those of octaves") {
    const Medium medium{.temperature_c = 5, .humidity_percent = 30};
    const ThirdOctaveModel model(medium);
    for (const double length_m : {0.0, 30.0, 300.0}) {
        Bands octaves;
        const Bands air = medium.attenuation_per_m();
        const auto surfaces = [](double octave) { return std::exp(-0.4 * octave - 1); };
        for (std::size_t b = 0; b < kBandCount; ++b)
            octaves[b] = static_cast<float>(surfaces(static_cast<double>(b)) *
                                            std::exp(-double{air[b]} * length_m));
        const ThirdOctaveModel::Values energies = model.energies(octaves, length_m);
        for (std::size_t t = 0; t < ThirdOctaveModel::kCount; ++t) {
            const double octave = std::clamp((static_cast<double>(t) - 1) / 3, 0.0, 7.0);
            const double m = air_attenuation_per_m(medium, ThirdOctaveModel::centre_hz(t));
            CAPTURE(length_m, t);
            // Rounding of the exponent, of up to 40.
            CHECK(double{energies[t]} ==
                  Approx(surfaces(octave) * std::exp(-m * length_m)).epsilon(1e-5));
        }
    }
    // Companion: the air of the octave is another one at 16 kHz.
    CHECK(air_attenuation_per_m(medium, ThirdOctaveModel::centre_hz(25)) >
          1.2 * air_attenuation_per_m(medium, ThirdOctaveModel::centre_hz(22)));
}

TEST_CASE("beside a silent octave third octaves are silent up to the next centre") {
    const ThirdOctaveModel model(Medium{});
    Bands octaves = Bands::filled(1);
    octaves[3] = 0;
    const ThirdOctaveModel::Values energies = model.energies(octaves, 1);
    for (std::size_t t = 0; t < ThirdOctaveModel::kCount; ++t) {
        CAPTURE(t);
        CHECK((energies[t] == 0) == (t > 7 && t < 13));
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
