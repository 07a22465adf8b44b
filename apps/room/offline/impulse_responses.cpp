#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "apps/room/frames/sound_at_listener.h"
#include "apps/room/images/box_images.h"
#include "apps/room/offline/diffuse_noise.h"
#include "apps/room/offline/offline.h"
#include "apps/room/waves/wave_join.h"
#include "apps/room/waves/wave_synthesis.h"
#include "audio/render/renderer.h"
#include "audio/spatial/hrtf.h"
#include "aula/engine/impulse_response.h"
#include "aula/exception.h"
#include "aula/measurement.h"
#include "engine/base/sampling.h"
#include "engine/tail/noise_carriers.h"

namespace aula {

namespace {

/// The renderer's settings for a pair of a measurement.
RendererConfig config_of(const Measurement& measurement, const OutputOptions& options) {
    Scene places;
    places.simulation = measurement.simulation;
    places.medium = measurement.medium;
    for (const Source& source : measurement.sources)
        places.sources.emplace_back().position = source.position_at(0);
    for (const Pose& receiver : measurement.receivers)
        places.sources.emplace_back().position = receiver.position;
    return renderer_config(places, measurement.length_s, FrameSettings{options});
}

}  // namespace

struct ImpulseResponses::State {
    State(const Measurement& measured, const OutputResources& output)
        : measurement(measured),
          hrtf(output.hrtf),
          headphones(output.headphones),
          config(config_of(measured, output.options)),
          is_array(measured.receivers.size() > 1) {
        if (!is_array && !measured.images)
            shared = make_noise_carriers(output.options.sample_rate_hz, measured.simulation.seed);
    }

    std::shared_ptr<const NoiseCarriers> carriers(std::size_t source, std::size_t receiver);
    std::shared_ptr<const DiffuseNoise> noise_of(std::size_t source, std::size_t set);
    std::vector<std::vector<float>> rendered(const SourceSound& sound, std::size_t receiver);

    const Measurement& measurement;
    std::shared_ptr<const Hrtf> hrtf;
    std::shared_ptr<const HeadphoneFilter> headphones;  ///< null: none
    RendererConfig config;
    bool is_array;                                ///< the receivers hear one field
    std::shared_ptr<const NoiseCarriers> shared;  ///< of all pairs, unless they are an array
    std::mutex mutex;
    std::pair<std::size_t, std::size_t> noise_set;  ///< source, and set of receivers, of `noise`
    std::shared_ptr<const DiffuseNoise> noise;      ///< the newest
    std::optional<CarrierFilters> filters;          ///< of the noises, all of one period
    std::vector<std::unique_ptr<ResponseRenderer>> idle;  ///< those that no thread uses
};

/// The period of the noise, s: longer than the responses, and long enough for the filters of low
/// octaves. Several channels read it at different offsets, at least an eighth of the period apart
/// for the first order and a sixteenth above; longer responses repeat them as those of one receiver
/// do.
double noise_period_s(double length_s, int order) {
    constexpr double kLonger_s = 0.5;
    const double parts = order == 0 ? 1 : order == 1 ? 8 : 16;
    return std::max(length_s + kLonger_s, std::min(parts * length_s, NoiseCarriers::kPeriod_s));
}

/// The noise of a source's reverberation at a set of receivers.
std::shared_ptr<const DiffuseNoise> ImpulseResponses::State::noise_of(std::size_t source,
                                                                      std::size_t set) {
    const std::lock_guard lock(mutex);
    if (noise && noise_set == std::pair(source, set)) return noise;
    const std::size_t first = set * DiffuseNoise::kMaxPoints;
    std::vector<Vec3> points;
    for (std::size_t r = first;
         r < std::min(first + DiffuseNoise::kMaxPoints, measurement.receivers.size()); ++r)
        points.push_back(measurement.receivers[r].position);
    noise_set = {source, set};
    if (!filters) {
        const double period_s = noise_period_s(measurement.length_s, field_order(config));
        filters.emplace(config.sample_rate_hz,
                        NoiseCarriers::fast_period(
                            config.sample_rate_hz,
                            static_cast<std::size_t>(std::ceil(period_s * config.sample_rate_hz))));
    }
    noise = std::make_shared<const DiffuseNoise>(
        points, filters->period_samples(), config.sample_rate_hz,
        double{measurement.response(source).speed_of_sound_m_s},
        derive_seed(NoiseCarriers::source_seed(measurement.simulation.seed,
                                               measurement.sources[source].name),
                    set));
    return noise;
}

std::shared_ptr<const NoiseCarriers> ImpulseResponses::State::carriers(std::size_t source,
                                                                       std::size_t receiver) {
    if (!is_array) return shared;
    const std::shared_ptr<const DiffuseNoise> noises =
        noise_of(source, receiver / DiffuseNoise::kMaxPoints);
    const std::vector<float>& at = noises->at(receiver % DiffuseNoise::kMaxPoints);
    return std::make_shared<const NoiseCarriers>(*filters, at);
}

/// The renderer's output at a receiver.
std::vector<std::vector<float>> ImpulseResponses::State::rendered(const SourceSound& sound,
                                                                  std::size_t receiver) {
    std::unique_ptr<ResponseRenderer> renderer;
    {
        const std::lock_guard lock(mutex);
        if (!idle.empty()) {
            renderer = std::move(idle.back());
            idle.pop_back();
        }
    }
    if (!renderer)
        renderer = std::make_unique<ResponseRenderer>(config, measurement.length_s, hrtf);
    auto response = renderer->response(sound, measurement.receivers[receiver]);
    if (headphones) equalize(*headphones, response);
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(renderer));
    return response;
}

ImpulseResponses::ImpulseResponses(const Measurement& measurement, const OutputOptions& options)
    : ImpulseResponses(measurement, OutputResources(options, "impulse responses")) {}

ImpulseResponses::ImpulseResponses(const Measurement& measurement, const OutputResources& output)
    : state_(std::make_unique<State>(measurement, output)) {}

ImpulseResponses responses_with(const Measurement& measurement, const OutputResources& output) {
    return {measurement, output};
}

ImpulseResponses::~ImpulseResponses() = default;

std::vector<std::vector<float>> ImpulseResponses::response(std::size_t source,
                                                           std::size_t receiver) const {
    const Measurement& m = state_->measurement;
    const std::size_t pair = m.pair(source, receiver);
    std::optional<PairWaves> modes;
    if (m.waves) modes = m.waves->pairs[pair];
    if (m.images) {
        // Binaural output has paths, of which each has its own direction in the head's filters.
        const EnergyResponse& energy = modes ? m.waves->rays[pair] : m.responses[pair];
        const bool has_paths = state_->config.output == OutputFormat::binaural;
        const double rate_hz = state_->config.sample_rate_hz;
        ImpulseResponse response{
            rate_hz,
            m.images->pressure(source, receiver, rate_hz,
                               static_cast<std::size_t>(std::ceil(m.length_s * rate_hz - 1e-6)),
                               field_order(state_->config), !has_paths),
            has_paths ? energy.paths : std::vector<SoundPath>{}};
        if (modes)
            WaveSynthesis(rate_hz, response.channels[0].size())
                .replace_below(
                    *modes,
                    [&](const SoundPath& path) {
                        return double{path.length_m} / double{energy.speed_of_sound_m_s};
                    },
                    response);
        return state_->rendered(
            source_sound(response, double{energy.speed_of_sound_m_s}, m.sources[source].gain_db),
            receiver);
    }
    EnergyResponse rays = modes ? m.waves->rays[pair] : m.responses[pair];
    // The carriers of an array are those of a place.
    if (state_->is_array) rays.listener = Vec3(0);
    ImpulseResponseBuilder builder(state_->carriers(source, receiver), m.medium, m.length_s,
                                   m.sources[source].name, field_order(state_->config));
    const double speed_m_s{rays.speed_of_sound_m_s};
    ImpulseResponse response;
    WaveSynthesis(state_->config.sample_rate_hz, builder.length_samples())
        .build(
            builder, rays, modes,
            [&](const SoundPath& path) { return double{path.length_m} / speed_m_s; }, response);
    const SourceSound sound = source_sound(response, speed_m_s, m.sources[source].gain_db);
    return state_->rendered(sound, receiver);
}

}  // namespace aula
