#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "engine/response/octave_bank.h"
#include "tests/engine/tail/response_building.h"

using namespace aula;
using namespace aula::test;

namespace {

double product_of(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += double{a[n]} * double{b[n]};
    return sum;
}

}  // namespace

TEST_CASE("sound from one direction is a plane wave") {
    EnergyResponse r = decay(0.5, all(0.5), all(1), 0.01);
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.directions[i] = DirectionMoments::of(Vec3(0, 1, 0)) * r.energy[i].sum();
    }
    const ImpulseResponse ir = build(r, 0.5);
    double worst = 0;
    double leak = 0;
    for (std::size_t n = 0; n < ir.channels[0].size(); ++n) {
        worst = std::max(worst, std::abs(double{ir.channels[0][n]} - double{ir.channels[1][n]}));
        leak = std::max(
            {leak, std::abs(double{ir.channels[2][n]}), std::abs(double{ir.channels[3][n]})});
    }
    // Rounding of v: 1 - |v| is up to 1e-7, and sqrt(1e-7 / 3) is 2e-4 of the peak of W.
    CHECK(worst < 1e-3);
    CHECK(leak < 1e-3);
    CHECK(energy_of(ir.channels[0]) > 0.1);
}

TEST_CASE("energy spread beyond a bin keeps its direction") {
    // Bins with gaps; a period of 63 Hz is as long as 16 bins.
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.2));
    for (std::size_t i = 5; i + 30 < r.bins.count(); i += 11) {
        r.energy[i][0] = 1;
        r.directions[i] = DirectionMoments::of(Vec3(0, 1, 0));
    }
    const ImpulseResponse ir = build(r, 0.2);
    double worst = 0;
    for (std::size_t n = 0; n < ir.channels[0].size(); ++n) {
        worst = std::max(worst, std::abs(double{ir.channels[0][n]} - double{ir.channels[1][n]}));
    }
    const double peak = double{*std::max_element(ir.channels[0].begin(), ir.channels[0].end())};
    CHECK(peak > 0);
    CHECK(worst < 2e-3 * peak);  // rounding, as for one direction
}

TEST_CASE("between two bins the direction is the energy-weighted mean of both") {
    // At 8 kHz, where the carrier has many degrees of freedom; energies three to one.
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.4));
    const std::size_t bin = r.bins.index(0.3);
    r.energy[bin][7] = 3;
    r.directions[bin] = DirectionMoments::of(Vec3(0, 1, 0)) * 3;
    r.energy[bin + 1][7] = 1;
    r.directions[bin + 1] = DirectionMoments::of(Vec3(0, -1, 0));
    const auto at = [&](double time_s) {
        return static_cast<std::size_t>(time_s * kRate_hz + 0.5);
    };
    const std::size_t middle = at((r.bins.begin_s(bin) + r.bins.end_s(bin)) / 2);
    const std::size_t edge = at(r.bins.end_s(bin));
    const std::size_t next = at((r.bins.begin_s(bin + 1) + r.bins.end_s(bin + 1)) / 2);
    constexpr int kSources = 100;
    std::array<double, 3> front{};
    std::array<double, 3> all{};
    for (int i = 0; i < kSources; ++i) {
        const ImpulseResponse ir = build(r, 0.4, 1, std::to_string(i));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t position = std::array{middle, edge, next}[k];
            for (std::size_t n = position - 4; n < position + 4; ++n) {
                front[k] += double{ir.channels[0][n]} * double{ir.channels[1][n]};
                all[k] += double{ir.channels[0][n]} * double{ir.channels[0][n]};
            }
        }
    }
    // Statistical: about 600 independent samples, 3.5 % of sqrt(1/3 - 1/4 + ...), and the change
    // over 4 of 192 samples to either side; 0.15 is four times that. Plane waves at the centres.
    CHECK(front[0] / all[0] == Approx(1).margin(0.05));
    CHECK(front[1] / all[1] == Approx(0.5).margin(0.15));
    CHECK(front[2] / all[2] == Approx(-1).margin(0.05));
}

TEST_CASE("a diffuse field has a third of the energy of W on each axis, all independent") {
    const ImpulseResponse ir = build(decay(1.0, all(2.0), all(1)), 1.0);
    for (std::size_t c = 1; c < 4; ++c) {
        // Each channel is normalised separately; bands overlap, hence per cent.
        CHECK(energy_of(ir.channels[c]) / energy_of(ir.channels[0]) ==
              Approx(1.0 / 3).epsilon(0.02));
        for (std::size_t d = 0; d < c; ++d) {
            const double correlation =
                product_of(ir.channels[c], ir.channels[d]) /
                std::sqrt(energy_of(ir.channels[c]) * energy_of(ir.channels[d]));
            // Statistical: 48000 * 0.14 effective samples, 1.2 %; 4 standard deviations.
            CHECK(std::abs(correlation) < 0.05);
        }
    }
}

TEST_CASE("in each octave a diffuse field has the same energy in each degree as in W") {
    constexpr int kSources = 8;
    std::array<std::array<double, kBandCount>, 4> energy{};  // [degree]
    for (int i = 0; i < kSources; ++i) {
        ImpulseResponse ir;
        ImpulseResponseBuilder(carriers(1), kNoAir, 1, std::to_string(i), 3)
            .build(decay(1, all(2), all(1)), ir);
        for (std::size_t c = 0; c < ir.channels.size(); ++c) {
            const auto degree = static_cast<std::size_t>(std::sqrt(static_cast<double>(c) + 0.5));
            const std::vector<double> samples(ir.channels[c].begin(), ir.channels[c].end());
            for (const auto& bands : OctaveBank(kRate_hz).process(samples))
                for (std::size_t b = 0; b < kBandCount; ++b)
                    energy[degree][b] += bands[b] * bands[b];
        }
    }
    for (std::size_t b = 0; b < kBandCount; ++b) {
        for (std::size_t degree = 1; degree < 4; ++degree) {
            CAPTURE(b, degree);
            // Statistical, fixed seeds: octaves exchange energy at their edges, of 8 tails with
            // about 2 B T / 13.8 = 13 independent samples each at 63 Hz.
            CHECK(db(energy[degree][b] / energy[0][b]) == Approx(0).margin(0.5));
        }
    }
    // Companion: channels are not normalised as those of N3D.
    CHECK(db(3 * energy[1][5] / energy[0][5]) > 0.5);
}

TEST_CASE("a partly directed field has the mean direction and the energy of the response") {
    EnergyResponse r = decay(1.0, all(2.0), all(1));
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.directions[i].intensity = Vec3(0.4F, 0, -0.3F) * r.energy[i].sum();
    }
    const ImpulseResponse ir = build(r, 1.0);
    const double w = energy_of(ir.channels[0]);
    // Statistical: correlations of 1.2 % times the share of the diffuse part; 4 standard
    // deviations.
    CHECK(product_of(ir.channels[0], ir.channels[3]) / w == Approx(0.4).margin(0.03));
    CHECK(product_of(ir.channels[0], ir.channels[1]) / w == Approx(0).margin(0.03));
    CHECK(product_of(ir.channels[0], ir.channels[2]) / w == Approx(-0.3).margin(0.03));
    const double axes =
        energy_of(ir.channels[1]) + energy_of(ir.channels[2]) + energy_of(ir.channels[3]);
    CHECK(axes / w == Approx(1).margin(0.05));
}

TEST_CASE("equal seeds give equal responses to the bit, different seeds different noise") {
    const EnergyResponse r = decay(0.2, all(0.5), all(1));
    CHECK(build(r, 0.2, 7).channels == build(r, 0.2, 7).channels);
    CHECK(build(r, 0.2, 7).channels != build(r, 0.2, 8).channels);
}

TEST_CASE("tails of sources of the same energy are uncorrelated and add by 3 dB") {
    const EnergyResponse r = decay(1.0, all(1.0), all(1));
    const std::array<std::string, 6> names{"left", "right", "source1", "source2", "a", "b"};
    std::vector<ImpulseResponse> tails;
    for (const std::string& name : names) tails.push_back(build(r, 1.0, 1, name));
    for (std::size_t i = 0; i < names.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            CAPTURE(names[i], names[k]);
            for (std::size_t c = 0; c < 4; ++c) {
                const std::vector<float>& one = tails[i].channels[c];
                const std::vector<float>& other = tails[k].channels[c];
                // Statistical: 24 kHz for 1 / 6.9 of a second, 7000 degrees of freedom, 1.2 %; 4
                // standard deviations, half of the requirement.
                CHECK(std::abs(product_of(one, other)) <
                      0.05 * std::sqrt(energy_of(one) * energy_of(other)));
                std::vector<float> both(one.size());
                for (std::size_t n = 0; n < one.size(); ++n) both[n] = one[n] + other[n];
                // The plane waves of low octaves have fewer degrees of freedom: 0.06 dB; 4 of them.
                CHECK(db(energy_of(both) / energy_of(one)) == Approx(db(2)).margin(0.25));
            }
        }
    }
    // Companion: with equal names they are equal and add by 6 dB.
    CHECK(build(r, 1.0, 1, "left").channels == tails[0].channels);
}

TEST_CASE("tails of different sources are uncorrelated at every lag") {
    // White and stationary: a shift of the same noise would be detected at any lag.
    EnergyResponse r = EnergyResponse::silent(TimeBins(0.5));
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] = Bands::filled(static_cast<float>(r.bins.end_s(i) - r.bins.begin_s(i)));
    }
    const ImpulseResponse left = build(r, 0.5, 1, "left");
    const ImpulseResponse right = build(r, 0.5, 1, "right");
    const auto at_lag = [&](const std::vector<float>& a, const std::vector<float>& b, int lag) {
        double sum = 0;
        for (std::size_t n = 2400; n + 2400 < a.size(); ++n) {
            sum += double{a[n]} * double{b[n + static_cast<std::size_t>(lag)]};
        }
        return sum / std::sqrt(energy_of(a) * energy_of(b));
    };
    double max = 0;
    for (int lag = 0; lag < 2400; ++lag) {
        for (const std::size_t c : {0U, 1U}) {
            max = std::max({max, std::abs(at_lag(left.channels[0], right.channels[c], lag)),
                            std::abs(at_lag(right.channels[c], left.channels[0], lag))});
        }
    }
    // Statistical: 19,200 degrees of freedom, 0.7 %; the largest of 9600 is within 5 standard
    // deviations.
    CHECK(max < 0.04);
}
