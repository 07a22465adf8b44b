#include "aula/engine/room_acoustics.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using aula::BandParameters;
using aula::Bands;
using aula::EnergyResponse;
using aula::kBandCount;
using aula::RoomParameters;
using aula::TimeBins;

namespace {

constexpr double kArrival_s = 0.0123;

double rate(double time_s) { return 6 * std::log(10.0) / time_s; }

/// Adds late energy that decays by 60 dB in `decay_s`, from the direct sound on, in all bands.
void add_decay(EnergyResponse& r, double energy, double decay_s) {
    const auto left = [&](double t) {
        return energy * std::exp(-rate(decay_s) * std::max(t - kArrival_s, 0.0));
    };
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] +=
            Bands::filled(static_cast<float>(left(r.bins.begin_s(i)) - left(r.bins.end_s(i))));
    }
}

EnergyResponse silence(double length_s) { return EnergyResponse::silent(TimeBins(length_s), 340); }

/// Direct sound and an exponential decay.
EnergyResponse example(double length_s, double direct, double late, double decay_s) {
    EnergyResponse r = silence(length_s);
    add_decay(r, late, decay_s);
    if (direct > 0) {
        r.paths.push_back({.order = 0,
                           .length_m = static_cast<float>(340 * kArrival_s),
                           .energy = Bands::filled(static_cast<float>(direct))});
    }
    return r;
}

bool all_empty(const BandParameters& p) {
    return !p.t20_s && !p.t30_s && !p.edt_s && !p.c50_db && !p.c80_db && !p.d50 && !p.ts_s &&
           !p.g_db;
}

}  // namespace

// Tolerances of the closed forms: energy is uniform within a bin of 1 ms (2 ms at 80 ms). For a
// decay of 1 s the error is of second order in 13.8 * 2 ms, 1e-4; plus rounding of floats.

TEST_CASE("a decay with direct sound has the parameters of the closed form") {
    const double t = 1.0;
    const double direct = 0.02;
    const double late = 0.05;
    const BandParameters p = aula::room_parameters(example(2.0, direct, late, t))[4];
    const auto after = [&](double s) { return late * std::exp(-rate(t) * s); };
    CHECK(p.t20_s.value() == Approx(t).epsilon(0.002));
    CHECK(p.t30_s.value() == Approx(t).epsilon(0.002));
    CHECK(p.c50_db.value() ==
          Approx(10 * std::log10((direct + late - after(0.05)) / after(0.05))).margin(0.005));
    CHECK(p.c80_db.value() ==
          Approx(10 * std::log10((direct + late - after(0.08)) / after(0.08))).margin(0.005));
    CHECK(p.d50.value() == Approx(1 - after(0.05) / (direct + late)).margin(5e-4));
    CHECK(p.ts_s.value() == Approx(late / rate(t) / (direct + late)).epsilon(0.002));
    CHECK(p.g_db.value() ==
          Approx(10 * std::log10((direct + late) * 400 * std::numbers::pi)).margin(0.005));
    // After the step of the direct sound the curve starts at x0 dB and is straight.
    CHECK(p.edt_s.value() == Approx(t).epsilon(0.002));
}

TEST_CASE("without direct sound time zero is the first arrival") {
    // Time zero is the start of its bin, 0.3 ms early.
    const double t = 0.8;
    const BandParameters p = aula::room_parameters(example(2.0, 0, 0.05, t))[0];
    CHECK(p.t30_s.value() == Approx(t).epsilon(0.002));
    CHECK(p.edt_s.value() == Approx(t).epsilon(0.005));
    CHECK(p.ts_s.value() == Approx(1 / rate(t) + 0.0003).margin(0.0003));

    EnergyResponse r = silence(1.0);
    add_decay(r, 0.05, t);
    r.paths.push_back({.order = 1,
                       .length_m = static_cast<float>(340 * kArrival_s),
                       .energy = Bands::filled(0.05F)});
    CHECK(aula::room_parameters(r)[0].ts_s.value() == Approx(0.5 / rate(t)).margin(0.0003));
}

TEST_CASE("time zero is the arrival of the direct sound, not the start of its bin") {
    EnergyResponse r = silence(0.5);
    const auto path = [&](double time_s, int order) {
        r.paths.push_back({.order = order,
                           .length_m = static_cast<float>(340 * time_s),
                           .energy = Bands::filled(1)});
    };
    path(0.0109, 0);
    path(0.0109 + 0.0499, 1);  // the bound of D50 lies within this reflection's bin
    CHECK(aula::room_parameters(r)[0].d50.value() == Approx(1));
    r.paths.pop_back();
    path(0.0109 + 0.0501, 1);
    CHECK(aula::room_parameters(r)[0].d50.value() == Approx(0.5));
}

TEST_CASE("with two slopes each parameter is fitted over its range") {
    EnergyResponse r = silence(4.0);
    add_decay(r, 1.0, 0.3);
    add_decay(r, 0.01, 2.0);
    const BandParameters p = aula::room_parameters(r)[2];
    // The least-squares line through the closed form of the curve, sampled every 0.1 ms.
    const auto fit = [](double from_db, double to_db) {
        double n = 0, t1 = 0, t2 = 0, l1 = 0, tl = 0;
        for (int i = 0; i < 40000; ++i) {
            const double t = i * 1e-4;
            const double level =
                10 *
                std::log10((std::exp(-rate(0.3) * t) + 0.01 * std::exp(-rate(2.0) * t)) / 1.01);
            if (level > from_db || level < to_db) continue;
            n += 1, t1 += t, t2 += t * t, l1 += level, tl += t * level;
        }
        return -60 / ((n * tl - t1 * l1) / (n * t2 - t1 * t1));
    };
    // 1 %: time zero is the start of its bin, 0.3 ms early.
    CHECK(p.edt_s.value() == Approx(fit(0, -10)).epsilon(0.01));
    CHECK(p.t20_s.value() == Approx(fit(-5, -25)).epsilon(0.01));
    CHECK(p.t30_s.value() == Approx(fit(-5, -35)).epsilon(0.01));
    CHECK(p.t30_s.value() > 2 * p.edt_s.value());
}

TEST_CASE("a decay time is empty unless the end is 10 dB below its range") {
    // A decay of 1 s falls by 60 dB per second, less 0.74 dB for the 12.3 ms before its start.
    const auto at = [](double length_s) {
        return aula::room_parameters(example(length_s, 0, 1, 1.0))[0];
    };
    CHECK(at(0.80).t30_s.has_value());  // 47 dB
    CHECK_FALSE(at(0.72).t30_s.has_value());
    CHECK(at(0.72).t20_s.has_value());
    CHECK(at(0.63).t20_s.has_value());  // 37 dB
    CHECK_FALSE(at(0.57).t20_s.has_value());
    CHECK(at(0.37).edt_s.has_value());  // 21.5 dB
    CHECK_FALSE(at(0.33).edt_s.has_value());
    CHECK(at(0.33).c80_db.has_value());
    CHECK(all_empty(at(0.17)));  // 9.5 dB
}

TEST_CASE("truncation of the response does not bend the decay curve") {
    // 46 dB: a Schroeder curve without the tail would give a T30 too short by 2 %.
    const BandParameters p = aula::room_parameters(example(0.788, 0, 1, 1.0))[0];
    CHECK(p.t30_s.value() == Approx(1.0).epsilon(0.003));
    CHECK(p.ts_s.value() == Approx(1 / rate(1.0)).margin(0.0005));
}

TEST_CASE("the centre time includes the truncated tail at its mean time") {
    // A decay of 1 s truncated after about 0.24 s, at -14 dB. The tail has 4 % of the energy and
    // its mean 72 ms after the end; it contributes a seventh of the centre time.
    EnergyResponse r = example(0.24, 1e-9, 1, 1.0);
    const double ts_s = aula::room_parameters(r)[0].ts_s.value();
    // The tail of an exponential decay is exact except for the bin width of 4 ms.
    CHECK(ts_s == Approx(1 / rate(1.0)).epsilon(0.005));
    // Companion: without the tail, and with one four times as late.
    const double cut = std::exp(-rate(1.0) * (r.bins.length_s() - kArrival_s));
    CHECK(cut * (r.bins.length_s() - kArrival_s + 1 / rate(1.0)) > 0.05 * ts_s);
    CHECK(cut * 3 / rate(1.0) > 0.05 * ts_s);
}

TEST_CASE("a response without decay has no parameters") {
    EnergyResponse r = silence(1.0);
    for (std::size_t i = 0; i < r.bins.count(); ++i) {
        r.energy[i] = Bands::filled(static_cast<float>(r.bins.end_s(i) - r.bins.begin_s(i)));
    }
    for (const BandParameters& p : aula::room_parameters(r)) CHECK(all_empty(p));
}

TEST_CASE("silence has no parameters") {
    for (const BandParameters& p : aula::room_parameters(silence(1.0))) CHECK(all_empty(p));
    for (const BandParameters& p : aula::room_parameters(EnergyResponse{})) CHECK(all_empty(p));
}

TEST_CASE("a silent band has no parameters while the others have") {
    EnergyResponse r = example(2.0, 0.1, 1, 1.0);
    for (Bands& e : r.energy) e[3] = 0;
    for (auto& p : r.paths) p.energy[3] = 0;
    const RoomParameters p = aula::room_parameters(r);
    CHECK(all_empty(p[3]));
    CHECK(p[2].t30_s.has_value());
}

TEST_CASE("direct sound alone has a strength and full definition but no decay") {
    EnergyResponse r = silence(1.0);
    r.paths.push_back({.order = 0,
                       .length_m = 10,
                       .energy = Bands::filled(static_cast<float>(1 / (400 * std::numbers::pi)))});
    const BandParameters p = aula::room_parameters(r)[0];
    CHECK(p.g_db.value() == Approx(0).margin(1e-5));  // 10 m in free field; a float
    CHECK(p.d50.value() == 1);
    CHECK(p.ts_s.value() == Approx(0).margin(1e-12));
    CHECK_FALSE(p.t20_s);
    CHECK_FALSE(p.t30_s);
    CHECK_FALSE(p.edt_s);
    CHECK_FALSE(p.c80_db);  // would be infinite
}

TEST_CASE("a response whose first arrival is faint and long before the others has no early decay") {
    // The curve is at 0 dB for 0.2 s. Its line over 10 dB falls by 60 dB in hours.
    EnergyResponse r = example(2.0, 0, 1, 0.01);
    const auto late = r.energy;
    const auto shift = static_cast<std::size_t>(200);
    for (std::size_t i = r.bins.count(); i-- > 0;)
        r.energy[i] = i < shift ? Bands{} : late[i - shift];
    r.energy[0] = Bands::filled(1e-6F);
    const BandParameters p = aula::room_parameters(r)[0];
    CHECK_FALSE(p.edt_s);
    CHECK(p.g_db);
}

TEST_CASE("no response gives NaN or infinity") {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> exponent(-38, 30);
    std::uniform_int_distribution<int> die(0, 9);
    const auto value = [&] {
        const int d = die(random);
        return d < 5 ? 0.0F : std::pow(10.0F, d < 8 ? -6.0F : exponent(random));
    };
    const auto good = [](const std::optional<double>& x) { return !x || std::isfinite(*x); };
    for (int trial = 0; trial < 3000; ++trial) {
        EnergyResponse r = silence(0.001 * std::pow(10, die(random) / 3.0));
        const int rare = die(random);
        for (Bands& e : r.energy) {
            for (float& x : e.value) x = die(random) < rare ? 0 : value();
        }
        for (int i = die(random); i > 3; --i) {
            r.paths.push_back(
                {.order = 10 - i, .length_m = static_cast<float>(40 - i * 3), .energy = {}});
            for (float& x : r.paths.back().energy.value) x = value();
        }
        for (const BandParameters& p : aula::room_parameters(r)) {
            REQUIRE((good(p.t20_s) && good(p.t30_s) && good(p.edt_s) && good(p.c50_db) &&
                     good(p.c80_db) && good(p.d50) && good(p.ts_s) && good(p.g_db)));
            REQUIRE((!p.t30_s || *p.t30_s > 0));
            REQUIRE((!p.d50 || (*p.d50 >= 0 && *p.d50 <= 1)));
        }
    }
}

TEST_CASE("Sabine's reverberation time includes absorption by walls and air") {
    // 5 x 4 x 3 m, absorption 0.2, c = 343: 24 ln(10) V / (c (S 0.2 + 4 m V)).
    const Bands t = aula::sabine_time_s(4.0 * 60 / 94, Bands::filled(0.2F), Bands{}, 343);
    CHECK(t[0] == Approx(24 * std::log(10.0) * 60 / (343 * 94 * 0.2)).epsilon(1e-6));
    const Bands both =
        aula::sabine_time_s(4.0 * 60 / 94, Bands::filled(0.2F), Bands::filled(0.01F), 343);
    CHECK(both[0] == Approx(24 * std::log(10.0) * 60 / (343 * (94 * 0.2 + 2.4))).epsilon(1e-6));
}

TEST_CASE("Eyring's reverberation time includes absorption by walls and air") {
    // 5 x 4 x 3 m, absorption 0.2, c = 343: 24 ln(10) V / (c S 0.22314).
    const Bands t = aula::eyring_time_s(4.0 * 60 / 94, Bands::filled(0.2F), Bands{}, 343);
    CHECK(t[0] == Approx(0.4609).margin(5e-5));
    // Air alone: 6 ln(10) / (c m).
    const Bands air = aula::eyring_time_s(4.0 * 60 / 94, Bands{}, Bands::filled(0.01F), 343);
    CHECK(air[0] == Approx(6 * std::log(10.0) / 3.43).epsilon(1e-5));
    CHECK(aula::eyring_time_s(4.0 * 60 / 94, Bands::filled(1), Bands{}, 343)[0] == 0);
}

TEST_CASE("clarity and definition count the truncated tail as late energy") {
    // A decay of 1 s truncated after about 0.24 s, at -14 dB: without the tail of 4 % C80 would be
    // 0.6 dB too high.
    const BandParameters p = aula::room_parameters(example(0.24, 1e-9, 1, 1.0))[0];
    const auto late = [](double limit_s) { return std::exp(-rate(1.0) * limit_s); };
    const auto clarity_db = [&](double limit_s) {
        return 10 * std::log10((1 - late(limit_s)) / late(limit_s));
    };
    // The tail of an exponential decay is exact except for the bin width of 4 ms.
    CHECK(p.c50_db.value() == Approx(clarity_db(0.05)).margin(0.03));
    CHECK(p.c80_db.value() == Approx(clarity_db(0.08)).margin(0.03));
    CHECK(p.d50.value() == Approx(1 - late(0.05)).margin(0.002));
}
