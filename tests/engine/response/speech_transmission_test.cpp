#include "engine/response/speech_transmission.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace {

using namespace aula;

/// A decay of reverberation time T with the total p^2 = 1, as at 1 m from the source.
EnergyResponse decay(double time_s) {
    EnergyResponse response = EnergyResponse::silent(TimeBins(3.0));
    const double rate = 6 * std::log(10.0) / time_s;
    for (std::size_t i = 0; i < response.bins.count(); ++i)
        response.energy[i] =
            Bands::filled(static_cast<float>((std::exp(-rate * response.bins.begin_s(i)) -
                                              std::exp(-rate * response.bins.end_s(i))) /
                                             (4 * std::numbers::pi)));
    return response;
}

/// Direct sound at 1 m.
EnergyResponse direct() {
    EnergyResponse response = EnergyResponse::silent(TimeBins(0.3));
    response.paths.push_back(
        {.length_m = 1, .energy = Bands::filled(static_cast<float>(1 / (4 * std::numbers::pi)))});
    return response;
}

/// m(F) of a decay.
double closed_form(double modulation_hz, double time_s) {
    return 1 / std::hypot(1, 2 * std::numbers::pi * modulation_hz * time_s / (6 * std::log(10.0)));
}

double transmission_index(double m) {
    return std::clamp((10 * std::log10(m / (1 - m)) + 15) / 30, 0.0, 1.0);
}

}  // namespace

TEST_CASE("the modulation transfer of an exponential decay is that of the closed form") {
    for (const double time_s : {0.3, 1.0, 2.0}) {
        const EnergyResponse response = decay(time_s);
        for (const double f : kModulations_hz) {
            INFO("T " << time_s << " s, F " << f << " Hz");
            // A decay that is constant within bins, up to 8 ms of 1 s: (rate h)^2 / 12 = 1e-3.
            CHECK(modulation_transfer(response, 3, f) ==
                  Approx(closed_form(f, time_s)).margin(1e-3));
            // Companion: a decay longer by 5 % is detected where the modulation is affected most.
            CHECK(modulation_transfer(response, 3, 4) !=
                  Approx(closed_form(4, 1.05 * time_s)).margin(1e-3));
        }
    }
    CHECK(modulation_transfer(direct(), 3, 12.5) == Approx(1));
    // Sound that arrives within the first bin, of half a millisecond.
    EnergyResponse at_once = EnergyResponse::silent(TimeBins(0.3));
    at_once.energy[0] = Bands::filled(1);
    CHECK(modulation_transfer(at_once, 3, 12.5) == Approx(1).margin(1e-3));
}

TEST_CASE("STI of an exponential decay, without noise and with noise, is that of the closed form") {
    const double time_s = 1.0;
    for (const double snr_db : {100.0, 6.0, 0.0}) {
        const Bands speech_db = Bands::filled(72);
        const Bands noise_db = Bands::filled(static_cast<float>(72 - snr_db));
        const auto sti = speech_transmission_index(decay(time_s), speech_db, noise_db);
        double expected = 0;
        for (const double f : kModulations_hz)
            expected +=
                transmission_index(closed_form(f, time_s) / (1 + std::pow(10, -snr_db / 10))) /
                kModulations_hz.size();
        INFO(snr_db << " dB");
        // Equal indices of all octaves: the weights sum to 1. Masking by the next lower octave is
        // at most -21 dB (of speech and noise, 75 dB), 0.8 % of the modulation, 0.0025 where m is
        // 1/2, and less than twice that for the longest modulations.
        CHECK(*sti == Approx(expected).margin(0.005));
        CHECK(*sti < expected);
    }
}

TEST_CASE("octaves without noise contribute their weights, less the redundancy of neighbours") {
    // IEC 60268-16:2011, table A.1, for male speech.
    constexpr std::array<double, 7> kWeights{0.085, 0.127, 0.230, 0.233, 0.309, 0.224, 0.173};
    constexpr std::array<double, 6> kRedundancies{0.085, 0.078, 0.065, 0.011, 0.047, 0.095};
    double expected = 0;
    for (std::size_t clear = 1; clear <= 7; ++clear) {
        Bands noise_db = Bands::filled(150);
        for (std::size_t k = 0; k < clear; ++k) noise_db[1 + k] = 0;
        expected += kWeights[clear - 1] - (clear > 1 ? kRedundancies[clear - 2] : 0);
        CHECK(*speech_transmission_index(direct(), Bands::filled(75), noise_db) ==
              Approx(expected).margin(1e-6));
    }
}

TEST_CASE("loud octaves mask the next higher ones, and speech below the threshold is lost") {
    // 80 dB in all octaves without noise: a = 0.5 * 80 - 59.8 = -19.8 dB, no loss above 15 dB. At
    // 105 dB the masking is -10 dB: all octaves but the lowest have (10 + 15) / 30.
    CHECK(*speech_transmission_index(direct(), Bands::filled(80), {}) == Approx(1));
    const double masked = 25 / 30.0;
    CHECK(*speech_transmission_index(direct(), Bands::filled(105), {}) ==
          Approx(0.085 + masked * (1 - 0.085) + 0.085 * (masked - std::sqrt(masked))).margin(1e-3));
    // At the threshold of 1 kHz, 6.5 dB, m = 1/2 there; the lower octaves are lost, 2 kHz has
    // (-1 + 15) / 30, 4 kHz (-1.5 + 15) / 30, 8 kHz (-5.5 + 15) / 30.
    const double k1 = 0.5, k2 = 14 / 30.0, k4 = 13.5 / 30, k8 = 9.5 / 30;
    const double k500 = (6.5 - 12 + 15) / 30;
    CHECK(*speech_transmission_index(direct(), Bands::filled(6.5F), {}) ==
          Approx(0.230 * k500 + 0.233 * k1 + 0.309 * k2 + 0.224 * k4 + 0.173 * k8 -
                 0.065 * std::sqrt(k500 * k1) - 0.011 * std::sqrt(k1 * k2) -
                 0.047 * std::sqrt(k2 * k4) - 0.095 * std::sqrt(k4 * k8))
              .margin(1e-4));
}

TEST_CASE("between 63 and 67 dB the masking rises by 1.8 dB per dB") {
    // 66 dB at 1 kHz mask 66 + 1.8 * 66 - 146.9 = 37.9 dB at 2 kHz, 2.1 dB below 40 dB of speech.
    Bands speech_db = Bands::filled(62);
    speech_db[4] = 66;
    speech_db[5] = 40;
    const double masked = (2.1 + 15) / 30;
    CHECK(
        *speech_transmission_index(direct(), speech_db, {}) ==
        Approx(1 - 0.309 * (1 - masked) + (0.011 + 0.047) * (1 - std::sqrt(masked))).margin(1e-3));
}

TEST_CASE("noise in one octave masks the next higher one") {
    // 110 dB at 500 Hz masks 100 dB at 1 kHz. Speech of 75 dB remains in the other octaves.
    Bands noise_db = Bands::filled(0);
    noise_db[3] = 110;
    CHECK(*speech_transmission_index(direct(), Bands::filled(75), noise_db) ==
          Approx(0.085 + 0.127 - 0.085 + 0.309 + 0.224 - 0.047 + 0.173 - 0.095).margin(1e-6));
}

TEST_CASE("STI needs energy in every octave from 125 Hz on") {
    EnergyResponse response = decay(1);
    for (Bands& energy : response.energy) energy[0] = 0;
    CHECK(speech_transmission_index(response, Bands::filled(60), {}));
    for (Bands& energy : response.energy) energy[7] = 0;
    CHECK_FALSE(speech_transmission_index(response, Bands::filled(60), {}));
}

TEST_CASE("a measured decay has the modulation transfer of the closed form, with its tail") {
    const double time_s = 1;
    const double rate = 6 * std::log(10.0) / time_s;
    SampledDecay decay{.energy = {}, .bin_s = 1e-3, .tail = {}};
    for (int i = 0; i < 300; ++i) decay.energy.push_back(std::exp(-rate * i * decay.bin_s));
    decay.tail = {.energy = std::exp(-rate * 0.3) / (1 - std::exp(-rate * decay.bin_s)),
                  .time_s = 1 / rate};
    for (const double f : kModulations_hz)
        // Bins of 1 ms: (rate h)^2 / 12 = 2e-5.
        CHECK(modulation_transfer(decay, f) == Approx(closed_form(f, time_s)).margin(1e-4));
    // Companion: without the tail, 1.6 % of the energy, it differs.
    decay.tail->energy = 0;
    CHECK(modulation_transfer(decay, 0.63) != Approx(closed_form(0.63, time_s)).margin(1e-3));
}

TEST_CASE("an index without levels is that of loud speech except for masking") {
    ModulationTransfers transfers{};
    for (auto& octave : transfers) octave.fill(0.5);  // index 0.5 in every octave
    CHECK(speech_transmission_index(transfers, {}) == Approx(0.5));
    const ReceivedLevels quiet{.speech_db = SpeechConditions::male_speech_db(20), .noise_db = {}};
    CHECK(speech_transmission_index(transfers, quiet) < 0.45);
    const ReceivedLevels noisy{.speech_db = SpeechConditions::male_speech_db(60),
                               .noise_db = Bands::filled(70)};
    CHECK(speech_transmission_index(transfers, noisy) < 0.25);
}

TEST_CASE("an index has the class and the rating of its range") {
    const auto of = [](double index) {
        return std::string(speech_class(index)) + " " + std::string(speech_rating(index));
    };
    CHECK(of(0) == "U bad");
    CHECK(of(0.299) == "U bad");
    CHECK(of(0.3) == "U poor");
    CHECK(of(0.359) == "U poor");
    CHECK(of(0.36) == "J poor");
    CHECK(of(0.44) == "H poor");
    CHECK(of(0.45) == "H fair");
    CHECK(of(0.5) == "G fair");
    CHECK(of(0.62) == "D good");
    CHECK(of(0.72) == "A good");
    CHECK(of(0.759) == "A excellent");
    CHECK(of(0.76) == "A+ excellent");
    CHECK(of(1) == "A+ excellent");
}

TEST_CASE("an index near a limit has the names of both sides") {
    CHECK(speech_name(0.449, kSpeechIndexRounding, speech_rating) == "poor to fair");
    CHECK(speech_name(0.451, kSpeechIndexRounding, speech_rating) == "poor to fair");
    CHECK(speech_name(0.456, kSpeechIndexRounding, speech_rating) == "fair");
    CHECK(speech_name(0.5, 0.05, speech_class) == "H to F");
    CHECK(speech_name(0.999, 0.01, speech_class) == "A+");
}
