#include <algorithm>
#include <utility>

#include "apps/session/base/session_options.h"
#include "apps/session/frames/sound_at_listener.h"
#include "audio/render/renderer.h"
#include "audio/spatial/hrtf.h"
#include "aula/engine/impulse_response.h"
#include "aula/exception.h"
#include "aula/measurement.h"

namespace aula {

namespace {

std::shared_ptr<const Hrtf> read_hrtf(const ImpulseResponseOptions& options) {
    return options.output == OutputFormat::binaural
               ? std::make_shared<const Hrtf>(options.hrtf, options.sample_rate_hz)
               : nullptr;
}

/// The renderer's settings for a pair of a measurement.
RendererConfig config_of(const Measurement& measurement, const ImpulseResponseOptions& options) {
    Scene places;
    places.simulation = measurement.simulation;
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
          carriers(make_noise_carriers(options.sample_rate_hz, measured.simulation.seed)) {}

    const Measurement& measurement;
    std::shared_ptr<const Hrtf> hrtf;
    RendererConfig config;
    std::shared_ptr<const NoiseCarriers> carriers;
};

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
    const EnergyResponse& energy = m.response(source, receiver);
    ImpulseResponseBuilder builder(state_->carriers, m.length_s, m.sources[source].name,
                                   field_order(state_->config));
    ImpulseResponse response;
    builder.build(energy, response);
    const SourceSound sound = source_sound(response, static_cast<double>(energy.speed_of_sound_m_s),
                                           m.sources[source].gain_db);
    return render_response(sound, state_->config, m.length_s, m.receivers[receiver], state_->hrtf);
}

}  // namespace aula
