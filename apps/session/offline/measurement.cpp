#include "apps/session/offline/measurement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include "apps/session/base/formatted.h"
#include "apps/session/frames/sound_at_listener.h"
#include "apps/session/offline/measurement_error.h"
#include "apps/session/offline/response_mean.h"
#include "aula/audio/realtime.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "engine/base/sampling.h"

namespace aula {

namespace {

constexpr int kMaxFrames = 2000;
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
constexpr const char* kTooQuiet = "more than 60 dB below its level at 1 m in every octave";

/// Frames of an independent window: for `dpc*` the window of the cache, limited so that enough
/// windows fit in a measurement.
int window_frames(const Simulation& simulation) {
    const bool cached =
        simulation.estimator == Estimator::dpc || simulation.estimator == Estimator::dpc_published;
    if (!cached) return kWindowFrames;
    return std::min(simulation.window_frames(), kMaxFrames / static_cast<int>(kFewestWindows));
}

/// True if, of the responses of `frames` frames from empty caches, the last has a smaller error
/// than the mean of all. The last response of `patch` contains all frames. That of `dpc` contains
/// the newest frames, as many as its window; the mean of all responses weights the first rays most.
/// The last is better up to 1.5 windows (measured).
bool last_is_best(const Simulation& simulation, int frames) {
    switch (simulation.estimator) {
        case Estimator::pt:
        case Estimator::dpc_published:
            return false;
        case Estimator::dpc:
            return 2 * frames <= 3 * simulation.window_frames();
        case Estimator::patch:
            return true;
    }
    return true;
}

/// Propagation with everything static at the listener's first pose, window by window.
class StaticPropagation {
 public:
    explicit StaticPropagation(const Scene& scene)
        : simulation_(scene.simulation), propagation_(scene, scene.simulation) {
        input_.listeners = {scene.listener.pose_at(0).position};
        for (const Source& source : scene.sources) {
            input_.sources.push_back(source.position_at(0));
            input_.source_rotations.push_back(source.pose_at(0).rotation());
        }
    }

    /// The combined result of the next `count` frames from empty caches, [source]; empty if
    /// `progress` requested a stop after a frame.
    std::vector<EnergyResponse> window(int count, const std::function<bool(int)>& progress) {
        if (windows_ > 0) propagation_.restart(derive_seed(simulation_.seed, windows_));
        ++windows_;
        const bool last = last_is_best(simulation_, count);
        std::vector<ResponseMean> means(input_.sources.size());
        for (int frame = 0; frame < count; ++frame) {
            propagation_.step(input_);
            if (!last || frame + 1 == count)
                for (std::size_t s = 0; s < means.size(); ++s)
                    means[s].add(propagation_.response(s));
            if (!progress(++frames_)) return {};
        }
        std::vector<EnergyResponse> responses;
        for (const ResponseMean& mean : means) responses.push_back(mean.value());
        return responses;
    }

    int frames() const { return frames_; }
    double response_length_s() const { return propagation_.response_length_s(); }
    std::vector<char> connected() const { return propagation_.sources_connected(input_); }

 private:
    const Simulation& simulation_;
    Propagation propagation_;
    FrameInput input_;
    std::uint64_t windows_ = 0;
    int frames_ = 0;
};

/// True if all relevant errors, including their own uncertainty, are within the wanted limits.
bool is_certain(const WindowedMean& mean) {
    const WindowedMean::Errors errors = mean.standard_errors();
    for (const MeasuredParameter p : kMeasuredParameters) {
        const auto& of_bands = errors[static_cast<std::size_t>(p)];
        const double worst = *std::max_element(of_bands.begin() + kFirstMeasuredBand,
                                               of_bands.begin() + kEndMeasuredBand);
        if (worst * mean.error_margin() > wanted_error(p)) return false;
    }
    return true;
}

/// The parameters with errors above the wanted limits, each with its worst octave; empty if there
/// are none.
std::string uncertain_parameters(const WindowedMean& mean) {
    struct Words {
        const char* name;
        const char* unit;
        double scale;
    };
    constexpr std::array<Words, kMeasuredParameters.size()> kWords{
        {{"level", "dB", 1}, {"C80", "dB", 1}, {"T30", "%", 100}, {"EDT", "%", 100}}};
    const WindowedMean::Errors errors = mean.standard_errors();
    std::string text;
    for (const MeasuredParameter p : kMeasuredParameters) {
        const auto i = static_cast<std::size_t>(p);
        const auto worst = std::max_element(errors[i].begin() + kFirstMeasuredBand,
                                            errors[i].begin() + kEndMeasuredBand);
        if (*worst <= wanted_error(p)) continue;
        const float centre_hz =
            kBandCentres_hz[static_cast<std::size_t>(worst - errors[i].begin())];
        text += formatted("%s%s %.3g %s at %.0f Hz (at most %g %s)", text.empty() ? "" : ", ",
                          kWords[i].name, kWords[i].scale * *worst, kWords[i].unit,
                          static_cast<double>(centre_hz), kWords[i].scale * wanted_error(p),
                          kWords[i].unit);
    }
    return text;
}

}  // namespace

std::optional<Measurement> measure(const Scene& scene, std::optional<int> frames,
                                   const Progress& progress) {
    StaticPropagation propagation(scene);
    const int max_frames = frames.value_or(kMaxFrames);
    const int window = frames ? *frames : window_frames(scene.simulation);
    const auto continues = [&](int done) {
        return !progress || progress(static_cast<double>(done) / max_frames);
    };
    const std::size_t count = scene.sources.size();
    std::vector<WindowedMean> means(count);
    std::vector<char> connected;
    std::vector<char> certain(count, 0);
    for (std::size_t next_check = kFewestWindows; propagation.frames() + window <= max_frames;) {
        const std::vector<EnergyResponse> responses = propagation.window(window, continues);
        if (responses.empty()) return std::nullopt;
        for (std::size_t s = 0; s < count; ++s) means[s].add(responses[s]);
        if (connected.empty()) connected = propagation.connected();
        if (std::none_of(connected.begin(), connected.end(), [](char c) { return c != 0; })) break;
        if (means[0].windows() < next_check) continue;
        next_check =
            static_cast<std::size_t>(std::ceil(kGrowth * static_cast<double>(means[0].windows())));
        for (std::size_t s = 0; s < count; ++s)
            certain[s] = !connected[s] || !is_audible(means[s].mean()) || is_certain(means[s]);
        if (std::all_of(certain.begin(), certain.end(), [](char c) { return c != 0; })) break;
    }

    Measurement m;
    m.length_s = propagation.response_length_s();
    m.frames = propagation.frames();
    for (std::size_t s = 0; s < count; ++s) {
        m.responses.push_back(means[s].mean());
        m.audible.push_back(connected[s] && is_audible(m.responses[s]));
        const std::string source = "source \"" + scene.sources[s].name + "\": ";
        if (!m.audible[s]) {
            m.warnings.push_back(source + "not audible at the listener, " +
                                 (connected[s] ? kTooQuiet : kNotConnected) +
                                 "; its parameters are omitted");
        } else if (!frames && !certain[s]) {
            const std::string uncertain = uncertain_parameters(means[s]);
            if (uncertain.empty()) continue;
            m.warnings.push_back(source + "standard errors after " + std::to_string(m.frames) +
                                 " frames: " + uncertain);
        }
    }
    return m;
}

std::vector<std::vector<float>> impulse_response(const Scene& scene, std::size_t source,
                                                 const Measurement& measurement,
                                                 const SessionOptions& options,
                                                 const std::shared_ptr<const Hrtf>& hrtf) {
    const double rate_hz = options.sample_rate_hz;
    const EnergyResponse& energy = measurement.responses[source];
    const RendererConfig config =
        renderer_config(scene, measurement.length_s, frame_settings(options, rate_hz));
    ImpulseResponseBuilder builder(make_noise_carriers(rate_hz, scene.simulation.seed),
                                   measurement.length_s, scene.sources[source].name,
                                   field_order(config));
    ImpulseResponse response;
    builder.build(energy, response);
    const SourceSound sound = source_sound(response, static_cast<double>(energy.speed_of_sound_m_s),
                                           scene.sources[source].gain_db);

    return render_response(sound, config, measurement.length_s, scene.listener.pose_at(0), hrtf);
}

}  // namespace aula
