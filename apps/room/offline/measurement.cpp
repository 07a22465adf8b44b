#include "aula/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "apps/output/formatted.h"
#include "apps/room/base/patch_warning.h"
#include "apps/room/offline/acoustic_parameters.h"
#include "apps/room/offline/interaural.h"
#include "apps/room/offline/measurement_error.h"
#include "apps/room/offline/static_propagation.h"
#include "apps/room/waves/wave_join.h"
#include "aula/engine/room_acoustics.h"
#include "aula/exception.h"
#include "engine/base/worker_pool.h"
#include "engine/scene/scene_values.h"

namespace aula {

namespace {

/// Groups of windows of all pairs together, to bound the memory, and the fewest of a pair.
constexpr std::size_t kMaxGroupsOfAll = 2048;
constexpr std::size_t kFewestGroups = 8;
/// Number of windows at the first evaluation of their spread, and its growth until the next one.
/// Evaluations after every window would bias the result: the measurement would stop where the
/// spread is small by chance.
constexpr std::size_t kFewestWindows = 16;
constexpr double kGrowth = 1.25;
/// Frames of an independent window for `pt` and `patch`. The error of `patch` after a number of
/// frames does not depend on their division into windows; more windows give a better estimate of
/// the error.
constexpr int kWindowFrames = 8;

constexpr const char* kNotConnected = "no path connects them";
constexpr const char* kTooLate = "its sound arrives after the end of the response";
constexpr const char* kTooQuiet = "more than 60 dB below its level at 1 m in every octave";

/// True if nothing arrives within a length.
bool is_silent(const EnergyResponse& response, double length_s) {
    return std::all_of(response.energy.begin(), response.energy.end(),
                       [](const Bands& energy) { return energy.sum() == 0; }) &&
           std::all_of(response.paths.begin(), response.paths.end(),
                       [&](const SoundPath& path) { return response.arrival_s(path) >= length_s; });
}

/// Frames of an independent window: for `dpc*` the window of the cache, limited so that enough
/// windows fit in a measurement.
int window_frames(const Simulation& simulation, int max_frames) {
    const bool cached =
        simulation.estimator == Estimator::dpc || simulation.estimator == Estimator::dpc_published;
    if (!cached) return kWindowFrames;
    return std::clamp(max_frames / static_cast<int>(kFewestWindows), 1, simulation.window_frames());
}

/// True if all relevant errors, including their own uncertainty, are within the wanted limits.
bool is_certain(const WindowedMean& mean, const MeasurementLimits& limits) {
    const WindowedMean::Errors errors = mean.standard_errors();
    for (const MeasuredParameter p : kMeasuredParameters) {
        const auto& of_bands = errors[static_cast<std::size_t>(p)];
        const double worst = *std::max_element(of_bands.begin() + kFirstMeasuredBand,
                                               of_bands.begin() + kEndMeasuredBand);
        if (worst * mean.error_margin() > wanted_error(limits, p)) return false;
    }
    return true;
}

/// The parameters with errors above the wanted limits, each with its worst octave; empty if there
/// are none.
std::string uncertain_parameters(const WindowedMean& mean, const MeasurementLimits& limits) {
    struct Words {
        MeasuredParameter parameter;
        const char* name;
        const char* unit;
        double scale;
    };
    constexpr std::array<Words, kMeasuredParameters.size()> kWords{
        {{MeasuredParameter::level, "level", "dB", 1},
         {MeasuredParameter::c80, "C80", "dB", 1},
         {MeasuredParameter::t30, "T30", "%", 100},
         {MeasuredParameter::edt, "EDT", "%", 100}}};
    const WindowedMean::Errors errors = mean.standard_errors();
    std::string text;
    for (const Words& words : kWords) {
        const auto& octaves = errors[static_cast<std::size_t>(words.parameter)];
        const auto worst = std::max_element(octaves.begin() + kFirstMeasuredBand,
                                            octaves.begin() + kEndMeasuredBand);
        const double wanted = wanted_error(limits, words.parameter);
        if (*worst <= wanted) continue;
        const float centre_hz = kBandCentres_hz[static_cast<std::size_t>(worst - octaves.begin())];
        text += formatted("%s%s %.3g %s at %.0f Hz (at most %g %s)", text.empty() ? "" : ", ",
                          words.name, words.scale * *worst, words.unit,
                          static_cast<double>(centre_hz), words.scale * wanted, words.unit);
    }
    return text;
}

/// The means of all pairs while windows are added.
class PairMeans {
 public:
    explicit PairMeans(std::size_t pairs)
        : means_(pairs, WindowedMean(std::clamp(kMaxGroupsOfAll / std::max<std::size_t>(pairs, 1),
                                                kFewestGroups, WindowedMean::kMaxGroups))) {}

    void add(const std::vector<EnergyResponse>& responses) {
        for (std::size_t pair = 0; pair < means_.size(); ++pair) means_[pair].add(responses[pair]);
    }

    std::size_t windows() const { return means_[0].windows(); }
    const WindowedMean& operator[](std::size_t pair) const { return means_[pair]; }

    /// True if the errors of all audible pairs are within the limits. Begins with the pair that was
    /// not at the last call.
    bool are_certain(const std::vector<char>& connected, const MeasurementLimits& limits) {
        for (std::size_t i = 0; i < means_.size(); ++i) {
            const std::size_t pair = (uncertain_ + i) % means_.size();
            if (!connected[pair] || !is_audible(means_[pair].mean())) continue;
            if (is_certain(means_[pair], limits)) continue;
            uncertain_ = pair;
            return false;
        }
        return true;
    }

 private:
    std::vector<WindowedMean> means_;  ///< [pair]
    std::size_t uncertain_ = 0;
};

/// The modes of the room, if the scene asks for them, joined to the responses of rays.
class MeasuredWaves {
 public:
    MeasuredWaves(const Scene& scene, const std::vector<Pose>& receivers)
        : sources_(scene.sources), receivers_(receivers) {
        if (scene.simulation.waves_hz > 0) join_.emplace(scene);
    }

    /// Adds the modes to the responses of a window, [pair].
    void join(std::vector<EnergyResponse>& responses) {
        if (!join_) return;
        const bool is_first = rays_.empty();
        if (is_first) rays_.resize(responses.size());
        for (std::size_t pair = 0; pair < responses.size(); ++pair) {
            if (is_first) {
                const Source& source = sources_[pair / receivers_.size()];
                pairs_.push_back(join_->pair(source.position_at(0),
                                             receivers_[pair % receivers_.size()].position,
                                             responses[pair]));
                energies_.push_back(pairs_[pair] ? pairs_[pair]->energy(responses[pair].bins)
                                                 : WaveEnergy());
            }
            rays_[pair].add(responses[pair]);
            if (pairs_[pair]) energies_[pair].join(responses[pair]);
        }
    }

    /// Gives the modes to the measurement.
    void finish(Measurement& m) const {
        if (!join_) return;
        // Who asks for modes is warned; where they are used if there are any, the report says it.
        std::vector<std::string>& lines =
            m.simulation.waves_hz == Simulation::kHighestWaves_hz ? m.without_waves : m.warnings;
        lines.insert(lines.end(), join_->warnings().begin(), join_->warnings().end());
        const auto with_modes = static_cast<std::size_t>(std::count_if(
            pairs_.begin(), pairs_.end(), [](const auto& p) { return p.has_value(); }));
        if (!join_->rooms().empty() && with_modes < pairs_.size())
            lines.push_back(
                formatted("waves: none at %zu of %zu pairs of a source and a receiver, "
                          "which are not in one room; rays are alone there",
                          pairs_.size() - with_modes, pairs_.size()));
        if (with_modes == 0) return;
        auto waves = std::make_shared<JoinedWaves>();
        waves->pairs = pairs_;
        for (const ResponseMean& rays : rays_) waves->rays.push_back(rays.value());
        for (const auto& pair : pairs_)
            if (pair) m.waves_below_hz = std::max(m.waves_below_hz, pair->masks().crossover_hz);
        m.waves = std::move(waves);
    }

 private:
    const std::vector<Source>& sources_;
    const std::vector<Pose>& receivers_;
    std::optional<WaveJoin> join_;
    std::vector<std::optional<PairWaves>> pairs_;  ///< [pair]
    std::vector<WaveEnergy> energies_;             ///< [pair]
    std::vector<ResponseMean> rays_;               ///< [pair]
};

void check(const SpeechConditions& speech) {
    for (std::size_t b = 0; b < kBandCount; ++b)
        if (!std::isfinite(speech.speech_db[b]) ||
            (speech.noise_db && !std::isfinite((*speech.noise_db)[b])))
            throw InputError("measurement: expected finite levels of speech and noise");
}

void check(const MeasurementOptions& options) {
    if (options.frames.value_or(1) < 1 || options.max_frames < 1)
        throw InputError("measurement: expected at least one frame");
    if (!(options.max_work_s > 0)) throw InputError("measurement: expected a time above 0");
    for (const MeasuredParameter p : kMeasuredParameters)
        if (!(wanted_error(options.limits, p) > 0))
            throw InputError("measurement: expected limits of standard errors above 0");
}

void check_positions(std::span<const Source> sources, std::span<const Pose> receivers) {
    if (sources.empty() || receivers.empty())
        throw InputError("measurement: expected at least one source and one receiver");
    const auto check = [](const Vec3& p) {
        // The comparison also fails for NaN.
        for (const float x : {p.x, p.y, p.z})
            if (!(std::abs(x) <= kLargestCoordinate_m))
                throw InputError("measurement: expected positions within -1e6 to 1e6 m");
    };
    for (const Source& source : sources) check(source.position_at(0));
    for (const Pose& receiver : receivers) check(receiver.position);
}

/// The source of a pair, and its receiver if there are several.
std::string name_of(const Measurement& m, std::size_t pair) {
    std::string name = "source \"" + m.sources[pair / m.receivers.size()].name + "\"";
    const std::size_t receiver = pair % m.receivers.size();
    if (!m.receiver_names.empty())
        name += " at \"" + m.receiver_names[receiver] + "\"";
    else if (m.receivers.size() > 1)
        name += " at receiver " + std::to_string(receiver);
    return name + ": ";
}

/// The parameters of all pairs.
std::vector<PairParameters> parameters_of(const Measurement& m, const PairMeans& means,
                                          const SpeechConditions& speech, bool third_octaves) {
    std::optional<Medium> air;
    if (third_octaves) air = m.medium;
    std::vector<PairParameters> parameters(m.responses.size());
    WorkerPool workers(m.simulation.threads.value_or(default_threads()));
    workers.run(parameters.size(), [&](std::size_t pair) {
        if (!m.audible[pair]) {
            if (third_octaves) parameters[pair].third_octaves.resize(kThirdOctaveParameterCount);
            return;
        }
        const Pose& receiver = m.receivers[pair % m.receivers.size()];
        const Source& source = m.sources[pair / m.receivers.size()];
        parameters[pair] =
            acoustic_parameters(means[pair], {lateral_axis(receiver, source.position_at(0)),
                                              with_power_of(speech, source.directivity), air});
    });
    return parameters;
}

/// True if the sound of a band has decayed by as much as T30 needs when the response ends: the last
/// quarter is 45 dB below the whole, 35 dB and the 10 dB of room_parameters().
bool has_decayed(const EnergyResponse& response, std::size_t band) {
    constexpr double kQuiet = 3.2e-5;
    double last = 0;
    for (std::size_t i = 0; i < response.bins.count(); ++i)
        if (response.bins.begin_s(i) >= 0.75 * response.bins.length_s())
            last += double{response.energy[i][band]};
    return last <= kQuiet * response.total(band);
}

/// Adds a line for each reason for which audible pairs have no T30.
void find_missing_decays(Measurement& m) {
    struct Missing {
        std::array<bool, kBandCount> bands{};
        std::vector<std::size_t> pairs{};
    };
    enum Reason : std::size_t { kTooLong, kTooNoisy, kTooLittle, kReasons };
    std::array<Missing, kReasons> missing;
    const auto reason_of = [&](std::size_t pair, std::size_t band) {
        if (!has_decayed(m.responses[pair], band)) return kTooLong;
        // The late slope decides whether the end of the response is clear of T30.
        const bool decays =
            m.parameters[pair].octave(AcousticParameter::t20, band).value.has_value();
        return decays ? kTooNoisy : kTooLittle;
    };
    for (std::size_t pair = 0; pair < m.responses.size(); ++pair) {
        for (std::size_t band = 0; m.audible[pair] && band < kBandCount; ++band) {
            if (m.parameters[pair].octave(AcousticParameter::t30, band).value) continue;
            Missing& of = missing[reason_of(pair, band)];
            of.bands[band] = true;
            if (of.pairs.empty() || of.pairs.back() != pair) of.pairs.push_back(pair);
        }
    }
    const bool lengthens = m.length_s < double{Simulation::kMaxIrLength_s};
    const std::array<std::string, kReasons> reasons{
        formatted("the sound decays for longer than the response of %.3g s", m.length_s) +
            (!lengthens ? ", the longest; more absorption shortens it"
             : m.simulation.ir_length_s
                 ? "; a longer --ir-length, or --ir-length auto, lets it decay"
                 : "; a longer --ir-length lets it decay"),
        "the late sound is too noisy; more --frames, or --quality fine, reduce the noise",
        "too little sound arrives after the first arrivals for a decay; there are hardly "
        "reflections"};
    for (std::size_t i = 0; i < missing.size(); ++i) {
        if (missing[i].pairs.empty()) continue;
        std::string bands;
        for (std::size_t band = 0; band < kBandCount; ++band)
            if (missing[i].bands[band])
                bands += (bands.empty() ? "" : ", ") +
                         formatted("%.0f", static_cast<double>(kBandCentres_hz[band]));
        const std::string where = missing[i].pairs.size() == 1
                                      ? name_of(m, missing[i].pairs[0])
                                      : formatted("%zu of %zu pairs of a source and a receiver: ",
                                                  missing[i].pairs.size(), m.responses.size());
        m.missing_decays.push_back(where + "no T30 at " + bands + " Hz: " + reasons[i]);
    }
}

/// Measures the sources of a scene at receivers.
std::optional<Measurement> measure(const Scene& scene, std::vector<Pose> receivers,
                                   const MeasurementOptions& options) {
    check(options);
    check(scene.speech);
    if (!options.receiver_names.empty() && options.receiver_names.size() != receivers.size())
        throw InputError("measurement: " + std::to_string(options.receiver_names.size()) +
                         " names of receivers; expected none or " +
                         std::to_string(receivers.size()));
    StaticPropagation propagation(scene, receivers);
    const int max_frames = options.frames.value_or(options.max_frames);
    const int window = options.frames
                           ? max_frames
                           : std::min(window_frames(scene.simulation, max_frames), max_frames);
    const double interaural_s = options.interaural
                                    ? interaural_work_s(scene.sources.size() * receivers.size(),
                                                        propagation.response_length_s())
                                    : 0;
    // The frames have at least half of the budget, which many pairs thus exceed.
    const double frames_s = std::max(options.max_work_s - interaural_s, options.max_work_s / 2);
    const auto continues = [&](int done) {
        const double of_frames = static_cast<double>(done) / max_frames;
        const double of_time = options.frames ? 0 : propagation.work_s() / frames_s;
        const double share = std::min(1.0, std::max(of_frames, of_time));
        const double all_frames_s = propagation.work_s() / share;
        return !options.progress ||
               options.progress(propagation.work_s() / (all_frames_s + interaural_s));
    };
    PairMeans means(scene.sources.size() * receivers.size());
    MeasuredWaves waves(scene, receivers);
    std::vector<char> connected;
    bool certain = false;
    bool at_end_of_budget = false;
    for (std::size_t next_check = kFewestWindows;
         !certain && propagation.frames() + window <= max_frames;) {
        std::vector<EnergyResponse> responses = propagation.window(window, continues);
        if (responses.empty()) return std::nullopt;
        waves.join(responses);
        means.add(responses);
        certain = propagation.images() != nullptr;
        if (certain) means.add(responses);  // for errors, which are 0
        if (connected.empty()) {
            connected = propagation.connected();
            // In the open a path over an edge, or through a pane, may be the only one.
            for (std::size_t pair = 0; pair < connected.size(); ++pair) {
                if (!responses[pair].paths.empty()) connected[pair] = 1;
            }
        }
        if (std::none_of(connected.begin(), connected.end(), [](char c) { return c != 0; })) break;
        at_end_of_budget =
            !options.frames && means.windows() >= 2 && propagation.work_s() >= frames_s;
        if (at_end_of_budget || certain) break;
        if (means.windows() < next_check) continue;
        next_check =
            static_cast<std::size_t>(std::ceil(kGrowth * static_cast<double>(means.windows())));
        certain = means.are_certain(connected, options.limits);
    }

    Measurement m;
    m.sources = scene.sources;
    m.receivers = std::move(receivers);
    m.simulation = scene.simulation;
    m.medium = scene.medium;
    m.length_s = propagation.response_length_s();
    m.receiver_names = options.receiver_names;
    m.frames = propagation.frames();
    m.limits = options.limits;
    m.patch_size_m = propagation.patch_size_m();
    m.images = propagation.images();
    if (at_end_of_budget)
        m.warnings.push_back(formatted(
            "the budget of the measurement ended it after %d frames%s", m.frames,
            scene.simulation.quality == Quality::draft ? "; --quality normal or fine takes longer"
                                                       : "; --quality fine takes longer"));
    waves.finish(m);
    warn_of_patch_size(scene.simulation, propagation.patch_size_m(), m.warnings);
    for (std::size_t pair = 0; pair < connected.size(); ++pair) {
        m.responses.push_back(means[pair].mean());
        m.inaudible.emplace_back(!connected[pair]                           ? kNotConnected
                                 : is_audible(m.responses[pair])            ? ""
                                 : is_silent(m.responses[pair], m.length_s) ? kTooLate
                                                                            : kTooQuiet);
        m.audible.push_back(m.inaudible[pair].empty());
        const bool has_errors = m.audible[pair] && !options.frames && !certain;
        m.uncertain.push_back(has_errors ? uncertain_parameters(means[pair], options.limits) : "");
    }
    if (options.parameters) {
        m.parameters = parameters_of(m, means, scene.speech, options.third_octaves);
        find_missing_decays(m);
    }
    const auto continues_after_frames = [&](double done) {
        const double all_s = propagation.work_s() + interaural_s;
        return !options.progress ||
               options.progress((propagation.work_s() + done * interaural_s) / all_s);
    };
    if (options.interaural && !add_interaural_parameters(m, continues_after_frames))
        return std::nullopt;
    return m;
}

}  // namespace

std::optional<Measurement> measure(const Scene& scene, std::span<const Source> sources,
                                   std::span<const Pose> receivers,
                                   const MeasurementOptions& options) {
    check_positions(sources, receivers);
    Scene measured = scene;
    measured.sources.assign(sources.begin(), sources.end());
    measured.listener = {.pose = receivers[0], .path = {}};
    return measure(measured, {receivers.begin(), receivers.end()}, options);
}

std::optional<Measurement> measure(const Scene& scene, const MeasurementOptions& options) {
    return measure(scene, std::vector<Pose>{scene.listener.pose_at(0)}, options);
}

std::string pair_warning(const Measurement& m, std::size_t pair) {
    if (!m.audible[pair])
        return name_of(m, pair) + "not audible" +
               (m.receivers.size() == 1 && m.receiver_names.empty() ? " at the listener, " : ", ") +
               m.inaudible[pair] + "; its parameters are omitted";
    if (m.uncertain[pair].empty()) return {};
    return name_of(m, pair) + "standard errors after " + std::to_string(m.frames) +
           " frames: " + m.uncertain[pair];
}

std::vector<std::string> warnings_of(const Measurement& m) {
    std::vector<std::string> lines = m.warnings;
    for (std::size_t pair = 0; pair < m.audible.size(); ++pair)
        if (std::string line = pair_warning(m, pair); !line.empty())
            lines.push_back(std::move(line));
    lines.insert(lines.end(), m.missing_decays.begin(), m.missing_decays.end());
    return lines;
}

MeasurementOptions within_budget(MeasurementOptions options, Quality quality) {
    constexpr double kDraftErrors = 2;
    if (quality == Quality::draft) {
        for (double* limit : {&options.limits.level_db, &options.limits.c80_db, &options.limits.t30,
                              &options.limits.edt})
            *limit *= kDraftErrors;
        options.max_work_s /= kDraftErrors * kDraftErrors;
    }
    if (quality == Quality::fine) options.max_work_s = std::numeric_limits<double>::infinity();
    return options;
}

}  // namespace aula
