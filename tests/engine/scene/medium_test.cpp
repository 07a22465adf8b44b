#include "aula/engine/medium.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace {

// Attenuation of pure tones in decibels per kilometre.
std::array<double, aula::kBandCount> attenuation_db_per_km(const aula::Medium& medium) {
    const aula::Bands m = medium.attenuation_per_m();
    std::array<double, aula::kBandCount> db{};
    for (std::size_t b = 0; b < db.size(); ++b)
        db[b] = 10 * std::log10(std::exp(1000.0 * double{m[b]}));
    return db;
}

}  // namespace

TEST_CASE("the speed of sound is 343.2 m/s at 20 degrees") {
    CHECK(aula::Medium{}.speed_of_sound_m_s() == Approx(343.2));
}

TEST_CASE("the speed of sound grows with the root of the absolute temperature") {
    aula::Medium cold;
    cold.temperature_c = 0;
    // Float rounding of a root and a product: a few eps.
    CHECK(cold.speed_of_sound_m_s() == Approx(343.2 * std::sqrt(273.15 / 293.15)).epsilon(1e-6));
}

TEST_CASE("air absorption agrees with the octave table of ISO 9613-2") {
    // ISO 9613-2:1996, table 2: dB/km at the octave centres 63 Hz to 8 kHz, made with ISO 9613-1.
    struct Row {
        float temperature_c;
        float humidity_percent;
        std::array<double, aula::kBandCount> db_per_km;
    };
    const Row rows[] = {
        {10, 70, {0.1, 0.4, 1.0, 1.9, 3.7, 9.7, 32.8, 117}},
        {20, 70, {0.1, 0.3, 1.1, 2.8, 5.0, 9.0, 22.9, 76.6}},
        {30, 70, {0.1, 0.3, 1.0, 3.1, 7.4, 12.7, 23.1, 59.3}},
        {15, 20, {0.3, 0.6, 1.2, 2.7, 8.2, 28.2, 88.8, 202}},
        {15, 50, {0.1, 0.5, 1.2, 2.2, 4.2, 10.8, 36.2, 129}},
        {15, 80, {0.1, 0.3, 1.1, 2.4, 4.1, 8.3, 23.7, 82.8}},
    };
    for (const Row& row : rows) {
        aula::Medium medium;
        medium.temperature_c = row.temperature_c;
        medium.humidity_percent = row.humidity_percent;
        const auto db = attenuation_db_per_km(medium);
        for (std::size_t b = 0; b < db.size(); ++b) {
            INFO(row.temperature_c << " C, " << row.humidity_percent << " %, band " << b);
            // Half a unit of the last printed digit, and 0.01 for the standard's own rounding.
            const double rounding = row.db_per_km[b] > 100 ? 0.51 : 0.06;
            CHECK(std::abs(db[b] - row.db_per_km[b]) < rounding);
        }
    }
}

TEST_CASE("1 kHz is attenuated by 4.66 dB per kilometre at 20 degrees and 50 % humidity") {
    // ISO 9613-1, table 1, three digits: half a unit of the last one.
    CHECK(std::abs(attenuation_db_per_km({})[4] - 4.66) < 0.006);
}

TEST_CASE("absorption doubles if frequency, density and vapour double") {
    // Absorption over pressure depends only on frequency over pressure and on the share of vapour.
    const float octave = std::pow(10.0F, 0.3F);
    aula::Medium dense;
    dense.pressure_kpa *= octave;
    dense.humidity_percent *= octave;
    const aula::Bands normal_air = aula::Medium{}.attenuation_per_m();
    const aula::Bands dense_air = dense.attenuation_per_m();
    for (std::size_t b = 0; b + 1 < aula::kBandCount; ++b) {
        // Rounding of the float settings, some eps.
        CHECK(dense_air[b + 1] == Approx(octave * normal_air[b]).epsilon(1e-5));
    }
}

TEST_CASE("a medium without air absorption attenuates nothing") {
    aula::Medium medium;
    medium.air_absorption = false;
    CHECK(medium.attenuation_per_m() == aula::Bands{});
}
