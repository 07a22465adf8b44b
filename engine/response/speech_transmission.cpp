#include "engine/response/speech_transmission.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

namespace aula {

namespace {

constexpr std::size_t kFirstBand = 1;  // 125 Hz
constexpr std::size_t kOctaves = kSpeechOctaves;

// IEC 60268-16:2011, tables A.1 (male), A.2 and 4.
constexpr std::array<double, kOctaves> kWeights{0.085, 0.127, 0.230, 0.233, 0.309, 0.224, 0.173};
constexpr std::array<double, kOctaves - 1> kRedundancies{0.085, 0.078, 0.065, 0.011, 0.047, 0.095};
constexpr std::array<double, kOctaves> kThreshold_db{46, 27, 12, 6.5, 7.5, 8, 12};

double power(double level_db) { return std::pow(10, level_db / 10); }

/// Level of the masking by the next lower octave, re the level of that octave.
double masking_slope_db(double lower_octave_db) {
    if (lower_octave_db < 63) return 0.5 * lower_octave_db - 65;
    if (lower_octave_db < 67) return 1.8 * lower_octave_db - 146.9;
    if (lower_octave_db < 100) return 0.5 * lower_octave_db - 59.8;
    return -10;
}

/// Transmission index of a modulation transfer, 0..1.
double transmission_index(double modulation) {
    constexpr double kRange_db = 15;  // IEC 60268-16
    // m = 1 is an infinite effective ratio.
    if (modulation >= 1) return 1;
    if (modulation <= 0) return 0;
    const double ratio_db = 10 * std::log10(modulation / (1 - modulation));
    return (std::clamp(ratio_db, -kRange_db, kRange_db) + kRange_db) / (2 * kRange_db);
}

}  // namespace

double modulation_transfer(const EnergyResponse& response, std::size_t band, double modulation_hz) {
    const double omega = 2 * std::numbers::pi * modulation_hz;
    std::complex<double> sum = 0;
    double total = 0;
    for (std::size_t i = 0; i < response.bins.count(); ++i) {
        // A bin of constant power has the transform of a rectangle.
        const double begin_s = response.bins.begin_s(i);
        const double half_s = (response.bins.end_s(i) - begin_s) / 2;
        const double energy{response.energy[i][band]};
        sum += energy * std::sin(omega * half_s) / (omega * half_s) *
               std::polar(1.0, -omega * (begin_s + half_s));
        total += energy;
    }
    for (const SoundPath& path : response.paths) {
        const double arrival_s = response.arrival_s(path);
        if (arrival_s >= response.bins.length_s()) continue;
        sum += double{path.energy[band]} * std::polar(1.0, -omega * arrival_s);
        total += double{path.energy[band]};
    }
    return std::abs(sum) / total;
}

double modulation_transfer(const SampledDecay& decay, double modulation_hz) {
    const double omega = 2 * std::numbers::pi * modulation_hz;
    std::complex<double> sum = 0;
    double total = 0;
    for (std::size_t i = 0; i < decay.energy.size(); ++i) {
        sum += decay.energy[i] *
               std::polar(1.0, -omega * (static_cast<double>(i) + 0.5) * decay.bin_s);
        total += decay.energy[i];
    }
    if (decay.tail) {
        // An exponential decay has the transform 1 / (1 + i omega tau).
        sum += decay.tail->energy * std::polar(1.0, -omega * decay.length_s()) /
               std::complex<double>(1, omega * decay.tail->time_s);
        total += decay.tail->energy;
    }
    return std::abs(sum) / total;
}

double speech_transmission_index(const ModulationTransfers& transfers,
                                 const std::optional<ReceivedLevels>& levels) {
    std::array<double, kOctaves> index{};
    double lower_db = 0;  // speech and noise in the next lower octave
    for (std::size_t k = 0; k < kOctaves; ++k) {
        double share = 1;
        if (levels) {
            const std::size_t band = kFirstBand + k;
            const double speech = power(double{levels->speech_db[band]});
            const double noise = levels->noise_db ? power(double{(*levels->noise_db)[band]}) : 0;
            const double masking = k == 0 ? 0 : power(lower_db + masking_slope_db(lower_db));
            share = speech / (speech + noise + masking + power(kThreshold_db[k]));
            lower_db = 10 * std::log10(speech + noise);
        }
        for (const double transfer : transfers[k])
            index[k] += transmission_index(transfer * share) / kModulations_hz.size();
    }
    double sti = 0;
    for (std::size_t k = 0; k < kOctaves; ++k) {
        sti += kWeights[k] * index[k];
        if (k + 1 < kOctaves) sti -= kRedundancies[k] * std::sqrt(index[k] * index[k + 1]);
    }
    return std::clamp(sti, 0.0, 1.0);
}

std::string_view speech_class(double index) {
    // Bands of 0.04 from J at 0.36 to A+ above 0.76.
    constexpr std::array<std::string_view, 12> kClasses{"U", "J", "I", "H", "G", "F",
                                                        "E", "D", "C", "B", "A", "A+"};
    const double above = std::floor((index - 0.32) / 0.04 + 1e-9);
    return kClasses[static_cast<std::size_t>(std::clamp(above, 0.0, 11.0))];
}

std::string_view speech_rating(double index) {
    if (index < 0.3) return "bad";
    if (index < 0.45) return "poor";
    if (index < 0.6) return "fair";
    return index < 0.75 ? "good" : "excellent";
}

std::string speech_name(double index, double margin, std::string_view (*name_of)(double)) {
    const std::string lowest(name_of(index - margin));
    const std::string highest(name_of(index + margin));
    return lowest == highest ? lowest : lowest + " to " + highest;
}

Bands received_db(const EnergyResponse& response, const Bands& source_db) {
    Bands levels_db = source_db;
    for (std::size_t b = 0; b < kBandCount; ++b)
        levels_db[b] += static_cast<float>(10 * std::log10(squared_pressure(response.total(b))));
    return levels_db;
}

std::optional<double> speech_transmission_index(const EnergyResponse& response,
                                                const Bands& speech_db,
                                                const std::optional<Bands>& noise_db) {
    ModulationTransfers transfers{};
    const ReceivedLevels levels{.speech_db = received_db(response, speech_db),
                                .noise_db = noise_db};
    for (std::size_t k = 0; k < kOctaves; ++k) {
        const std::size_t band = kFirstBand + k;
        if (!(response.total(band) > 0)) return std::nullopt;
        for (std::size_t m = 0; m < kModulations_hz.size(); ++m)
            transfers[k][m] = modulation_transfer(response, band, kModulations_hz[m]);
    }
    return speech_transmission_index(transfers, levels);
}

}  // namespace aula
