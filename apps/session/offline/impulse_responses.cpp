#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "apps/session/base/session_options.h"
#include "apps/session/frames/sound_at_listener.h"
#include "apps/session/offline/diffuse_noise.h"
#include "apps/session/waves/wave_join.h"
#include "audio/render/renderer.h"
#include "audio/spatial/hrtf.h"
#include "aula/engine/impulse_response.h"
#include "aula/exception.h"
#include "aula/measurement.h"
#include "engine/base/sampling.h"
#include "engine/tail/noise_carriers.h"

namespace aula {

namespace {

std::shared_ptr<const Hrtf> read_hrtf(const ImpulseResponseOptions& options) {
    return options.output == OutputFormat::binaural
               ? load_hrtf(options.hrtf, options.sample_rate_hz)
               : nullptr;
}

/// The renderer's settings for a pair of a measurement.
RendererConfig config_of(const Measurement& measurement, const ImpulseResponseOptions& options) {
    Scene places;
    places.simulation = measurement.simulation;
    places.medium = measurement.medium;
    for (const Source& source : measurement.sources)
        places.sources.emplace_back().position = source.position_at(0);
    for (const Pose& receiver : measurement.receivers)
        places.sources.emplace_back().position = receiver.position;
    return renderer_config(places, measurement.length_s,
                           {.sample_rate_hz = options.sample_rate_hz,
                            .block = options.block,
                            .output = options.output,
                            .ambisonic_order = options.ambisonic_order,
                            .half_precision_tail = options.half_precision_tail});
}

void check(const ImpulseResponseOptions& options) {
    if (!(options.sample_rate_hz >= 8000 && options.sample_rate_hz <= 384000))
        throw InputError("impulse responses: expected a sample rate from 8000 to 384000 Hz");
    if (options.block < 1 || options.block > 8192)
        throw InputError("impulse responses: expected blocks of 1 to 8192 samples");
    if (options.ambisonic_order < 1 || options.ambisonic_order > 3)
        throw InputError("impulse responses: expected an ambisonic order from 1 to 3");
}

}  // namespace

struct ImpulseResponses::State {
    State(const Measurement& measured, const ImpulseResponseOptions& options,
          std::shared_ptr<const Hrtf> head)
        : measurement(measured),
          hrtf(std::move(head)),
          config(config_of(measured, options)),
          is_array(measured.receivers.size() > 1) {
        if (!is_array)
            shared = make_noise_carriers(options.sample_rate_hz, measured.simulation.seed);
    }

    std::shared_ptr<const NoiseCarriers> carriers(std::size_t source, std::size_t receiver);
    std::shared_ptr<const DiffuseNoise> noise_of(std::size_t source, std::size_t set);

    const Measurement& measurement;
    std::shared_ptr<const Hrtf> hrtf;
    RendererConfig config;
    bool is_array;                                ///< the receivers hear one field
    std::shared_ptr<const NoiseCarriers> shared;  ///< of all pairs, unless they are an array
    std::mutex mutex;
    std::pair<std::size_t, std::size_t> noise_set;  ///< source, and set of receivers, of `noise`
    std::shared_ptr<const DiffuseNoise> noise;      ///< the newest
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
    noise = std::make_shared<const DiffuseNoise>(
        points,
        NoiseCarriers::fast_period(config.sample_rate_hz,
                                   static_cast<std::size_t>(std::ceil(
                                       noise_period_s(measurement.length_s, field_order(config)) *
                                       config.sample_rate_hz))),
        config.sample_rate_hz, double{measurement.response(source).speed_of_sound_m_s},
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
    return std::make_shared<const NoiseCarriers>(config.sample_rate_hz, at);
}

ImpulseResponses::ImpulseResponses(const Measurement& measurement,
                                   const ImpulseResponseOptions& options)
    : ImpulseResponses(measurement, (check(options), options), read_hrtf(options)) {}

ImpulseResponses::ImpulseResponses(const Measurement& measurement,
                                   const ImpulseResponseOptions& options,
                                   std::shared_ptr<const Hrtf> hrtf) {
    check(options);
    state_ = std::make_unique<State>(measurement, options, std::move(hrtf));
}

ImpulseResponses::~ImpulseResponses() = default;

std::vector<std::vector<float>> ImpulseResponses::response(std::size_t source,
                                                           std::size_t receiver) const {
    const Measurement& m = state_->measurement;
    const std::size_t pair = m.pair(source, receiver);
    const PairWaves* const waves =
        m.waves && m.waves->pairs[pair] ? &*m.waves->pairs[pair] : nullptr;
    const EnergyResponse& energy = waves != nullptr ? m.waves->rays[pair] : m.responses[pair];
    ImpulseResponseBuilder builder(state_->carriers(source, receiver), m.medium, m.length_s,
                                   m.sources[source].name, field_order(state_->config));
    ImpulseResponse response;
    builder.build(energy, response);
    const SourceSound sound = source_sound(response, static_cast<double>(energy.speed_of_sound_m_s),
                                           m.sources[source].gain_db);
    const auto render = [&](const SourceSound& part) {
        return render_response(part, state_->config, m.length_s, m.receivers[receiver],
                               state_->hrtf);
    };
    if (waves == nullptr) return render(sound);
    // The direct sound remains whole; modes and all other rays are joined.
    std::vector<std::vector<float>> result;
    const auto add = [&](const std::vector<std::vector<float>>& part) {
        result.resize(part.size());
        for (std::size_t c = 0; c < part.size(); ++c) {
            result[c].resize(std::max(result[c].size(), part[c].size()));
            for (std::size_t i = 0; i < part[c].size(); ++i) result[c][i] += part[c][i];
        }
    };
    const double rate_hz = state_->config.sample_rate_hz;
    const std::vector<float> silence(builder.length_samples());
    SourceSound silent = sound;
    silent.direct.reset();
    silent.early.clear();
    for (std::size_t c = 0; c < response.channels.size(); ++c) silent.ambisonics[c] = silence;

    SourceSound rays = sound;
    if (waves->has_direct()) {
        rays.direct.reset();
        SourceSound direct = silent;
        direct.direct = sound.direct;
        std::vector<std::vector<float>> part = render(direct);
        for (std::vector<float>& channel : part) cut_subsonic(rate_hz, channel);
        add(part);
    }
    std::vector<std::vector<float>> high = render(rays);
    for (std::vector<float>& channel : high) keep_high(m.waves->masks, rate_hz, channel);
    add(high);
    const auto modes = waves->impulse_response(rate_hz, builder.length_samples());
    SourceSound low = silent;
    for (std::size_t c = 0; c < std::min(modes.size(), response.channels.size()); ++c) {
        low.ambisonics[c] = modes[c];
    }
    add(render(low));
    return result;
}

}  // namespace aula
