#include "apps/room/offline/response_analysis.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "apps/output/formatted.h"
#include "apps/room/offline/acoustic_parameters.h"
#include "apps/room/offline/measurement_text.h"
#include "aula/audio/sound_file.h"
#include "aula/engine/third_octaves.h"
#include "aula/exception.h"
#include "engine/response/measured_decay.h"

namespace aula {

namespace {

constexpr double kShortest_s = 0.05;  // C50 needs it

/// Indices of the lowest bands (FrequencyBand::at).
constexpr int kFirstOctave = -4;
constexpr int kFirstThird = -13;

/// What one band lacks.
enum class Lack { nothing, rate, decay, t20_range, t30_range, width };

struct BandResult {
    AnalysedBand band;
    std::optional<SampledDecay> decay;
    Lack lack = Lack::nothing;
};

/// Removes a decay time that the filter of the band cannot resolve.
bool resolves(std::optional<double>& time_s, double width_hz) {
    constexpr double kLeastProduct = 4;
    if (!time_s || width_hz * *time_s >= kLeastProduct) return true;
    time_s.reset();
    return false;
}

BandResult analyse_band(std::span<const float> response, double sample_rate_hz, std::size_t zero,
                        const FrequencyBand& band) {
    // Anti-aliasing filters leave less than the last hundredth of the spectrum.
    constexpr double kUsable = 0.99;
    if (band.high_hz > kUsable * sample_rate_hz / 2) return {{}, {}, Lack::rate};
    BandResult result{{}, measured_decay(response, sample_rate_hz, zero, band), Lack::nothing};
    if (!result.decay) {
        result.lack = Lack::decay;
        return result;
    }
    const DecayCurve curve(*result.decay);
    if (curve.tail() > 0 && curve.total() > curve.tail())
        result.band.range_db = 10 * std::log10(curve.total() / curve.tail());
    BandParameters& p = result.band.parameters = band_parameters(curve);
    p.g_db.reset();
    // The noise of a sound that is no response may exceed its start.
    if (p.d50 && *p.d50 < 0) p.d50.reset();
    if (!p.t30_s) result.lack = p.t20_s ? Lack::t30_range : Lack::t20_range;
    for (std::optional<double>* const time_s : {&p.t20_s, &p.t30_s, &p.edt_s})
        if (!resolves(*time_s, band.width_hz())) result.lack = Lack::width;
    // Faint noise after a decay as short makes the end of T30 longer.
    if (!p.t20_s) p.t30_s.reset();
    return result;
}

/// Lines that name the bands which lack something, for each kind of bands.
class Lacks {
 public:
    void add(Lack lack, const std::string& band, const AnalysedBand& analysed) {
        Entry& entry = entries_[static_cast<std::size_t>(lack)];
        entry.bands += (entry.bands.empty() ? "" : ", ") + band;
        const double range_db = analysed.range_db.value_or(0);
        entry.least_db = std::min(entry.least_db, range_db);
        entry.most_db = std::max(entry.most_db, range_db);
    }

    void write(const std::string& name, const std::string& kind,
               std::vector<std::string>& lines) const {
        const auto line = [&](Lack lack, const std::string& what) {
            const Entry& entry = entries_[static_cast<std::size_t>(lack)];
            if (!entry.bands.empty())
                lines.push_back(name + ": " + kind + " of " + entry.bands + " Hz: " + what);
        };
        const auto ranges = [&](Lack lack) {
            const Entry& entry = entries_[static_cast<std::size_t>(lack)];
            const std::string least = fixed_text(std::floor(entry.least_db), 0);
            const std::string most = fixed_text(std::floor(entry.most_db), 0);
            std::string text = "the decay range is " + least;
            if (least != most) text += " to " + most;
            return text + " dB";
        };
        line(Lack::rate, "above the range of the sample rate");
        line(Lack::decay, "no decay above the noise");
        line(Lack::t20_range,
             "no T20 and T30, " + ranges(Lack::t20_range) + "; expected 35 dB for T20");
        line(Lack::t30_range, "no T30, " + ranges(Lack::t30_range) + "; expected 45 dB");
        line(Lack::width,
             "the decay is as short as that of the filter: band width times T is below 4");
    }

 private:
    struct Entry {
        std::string bands;
        double least_db = 1000, most_db = 0;
    };
    std::array<Entry, 6> entries_;
};

/// A run of samples at the largest magnitude, as a converter at its limit leaves it. That limit is
/// full scale: a quiet response of few bits has equal samples as well.
bool is_clipped(std::span<const float> response) {
    constexpr int kRun = 4;
    constexpr float kFullScale = 0.99F;  // the largest integer of 8 bits is 0.992
    float largest = 0;
    for (const float x : response) largest = std::max(largest, std::abs(x));
    if (largest < kFullScale) return false;
    int run = 0;
    for (const float x : response) {
        run = std::abs(x) >= largest * (1 - 1e-4F) ? run + 1 : 0;
        if (run == kRun) return true;
    }
    return false;
}

/// The modulation transfer of the octaves of speech; without it a warning.
std::optional<ModulationTransfers> speech_transfers(const std::vector<BandResult>& octaves,
                                                    const std::string& name,
                                                    std::vector<std::string>& warnings) {
    ModulationTransfers transfers{};
    std::string lacking;
    for (std::size_t k = 0; k < kSpeechOctaves; ++k) {
        const BandResult& octave = octaves[k + 1];
        // As a simulated one, it needs the whole response.
        if (!octave.decay || !octave.band.parameters.c50_db) {
            lacking += (lacking.empty() ? "" : ", ") + band_name(k + 1);
            continue;
        }
        for (std::size_t m = 0; m < kModulations_hz.size(); ++m)
            transfers[k][m] = modulation_transfer(*octave.decay, kModulations_hz[m]);
    }
    if (lacking.empty()) return transfers;
    warnings.push_back(name + ": no STI, which needs C50 of the octaves of " + lacking + " Hz");
    return std::nullopt;
}

/// The response without the offset of a converter, the mean of its last tenth. A step at its start
/// would be loud in the low octaves.
std::vector<float> without_offset(std::span<const float> response) {
    const std::span<const float> last = response.last((response.size() + 9) / 10);
    const double sum = std::accumulate(last.begin(), last.end(), 0.0);
    const auto offset = static_cast<float>(sum / static_cast<double>(last.size()));
    std::vector<float> samples(response.begin(), response.end());
    for (float& sample : samples) sample -= offset;
    return samples;
}

/// The response to its last sample that is not 0: silence that a program appended is no noise.
std::span<const float> sounding(std::span<const float> response) {
    while (!response.empty() && response.back() == 0)
        response = response.first(response.size() - 1);
    return response;
}

}  // namespace

ResponseAnalysis analyse_response(const std::string& name, std::span<const float> response,
                                  double sample_rate_hz, const AnalysisOptions& options) {
    const std::span<const float> sound = sounding(response);
    if (sound.empty()) throw InputError(name, "", "is silent; expected an impulse response");
    const std::vector<float> samples = without_offset(sound);
    const std::size_t zero = first_arrival(samples);
    const double after_s = static_cast<double>(sound.size() - zero) / sample_rate_hz;
    if (after_s < kShortest_s)
        throw InputError(name, "",
                         "lasts " + fixed_text(1000 * after_s, 1) +
                             " ms from its first arrival on; expected an impulse response of at "
                             "least 50 ms");
    ResponseAnalysis analysis{.name = name,
                              .sample_rate_hz = sample_rate_hz,
                              .length_s = static_cast<double>(response.size()) / sample_rate_hz,
                              .zero_s = static_cast<double>(zero) / sample_rate_hz,
                              .parameters = {},
                              .range_db = {},
                              .transfers = {},
                              .third_octaves = {},
                              .warnings = {}};
    if (is_clipped(sound))
        analysis.warnings.push_back(
            name + ": is clipped: several samples in a row have the largest magnitude");
    const auto analyse = [&](int index, int per_octave) {
        return analyse_band(samples, sample_rate_hz, zero, FrequencyBand::at(index, per_octave));
    };
    std::vector<BandResult> octaves;
    RoomParameters bands;
    Lacks lacks;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        octaves.push_back(analyse(kFirstOctave + static_cast<int>(b), 1));
        bands[b] = octaves[b].band.parameters;
        analysis.range_db[b] = octaves[b].band.range_db;
        lacks.add(octaves[b].lack, band_name(b), octaves[b].band);
    }
    lacks.write(name, "octaves", analysis.warnings);
    analysis.transfers = speech_transfers(octaves, name, analysis.warnings);
    std::optional<double> sti;
    if (analysis.transfers) sti = speech_transmission_index(*analysis.transfers, options.speech);
    analysis.parameters = acoustic_parameters(bands, sti);
    if (!options.third_octaves) return analysis;
    Lacks third_lacks;
    for (std::size_t t = 0; t < kThirdOctaveCount; ++t) {
        const BandResult third = analyse(kFirstThird + static_cast<int>(t), 3);
        third_lacks.add(third.lack, third_octave_name(t), third.band);
        analysis.third_octaves.push_back(third.band);
    }
    third_lacks.write(name, "third octaves", analysis.warnings);
    return analysis;
}

std::vector<std::optional<ResponseAnalysis>> analyse_file(const std::filesystem::path& file,
                                                          const AnalysisOptions& options) {
    const SoundChannels sound = read_channels(file);
    std::vector<std::string> warnings = sound.warnings;
    const std::size_t channels = sound.channels.size();
    std::vector<std::optional<ResponseAnalysis>> all(channels);
    ResponseAnalysis* first = nullptr;
    for (std::size_t c = 0; c < channels; ++c) {
        const std::string name =
            file.string() + (channels > 1 ? " channel " + std::to_string(c + 1) : "");
        if (channels > 1 && sounding(sound.channels[c]).empty()) {
            warnings.push_back(name + ": is silent");
            continue;
        }
        all[c] = analyse_response(name, sound.channels[c], sound.sample_rate_hz, options);
        all[c]->name = file.stem().string() + name.substr(file.string().size());
        if (first == nullptr) first = &*all[c];
    }
    if (first == nullptr)
        throw InputError(file.string(), "", "is silent; expected an impulse response");
    first->warnings.insert(first->warnings.begin(), warnings.begin(), warnings.end());
    return all;
}

}  // namespace aula
