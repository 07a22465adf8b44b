#include "apps/session/frame_maker.h"

#include <chrono>

#include "apps/session/sound_at_listener.h"

namespace aula {

FrameMaker::FrameMaker(const Scene& scene, double sample_rate_hz, int block, OutputFormat output,
                       std::shared_ptr<const Hrtf> hrtf)
    : scene_(scene),
      propagation_(scene, scene.simulation),
      impulse_responses_(sample_rate_hz, propagation_.response_length_s(), scene.simulation.seed),
      config_{.sample_rate_hz = sample_rate_hz,
              .block = block,
              .sources = scene.sources.size(),
              .response_samples = impulse_responses_.length_samples(),
              .frame_s = 1.0 / static_cast<double>(scene.simulation.frame_rate_hz),
              .output = output,
              .longest_delay_s = longest_delay_s(scene)},
      builder_(config_, std::move(hrtf)),
      responses_(scene.sources.size()),
      sounds_(scene.sources.size()) {
    input_.sources.resize(scene.sources.size());
    input_.listeners.resize(1);
}

void FrameMaker::propagate(double time_s, const PlayControls& controls) {
    input_.time_s = time_s;
    input_.listeners[0] = controls.listener_at(scene_, time_s).position;
    for (std::size_t s = 0; s < scene_.sources.size(); ++s)
        input_.sources[s] =
            controls.source(s).position.value_or(scene_.sources[s].position_at(time_s));
    propagation_.step(input_);
}

void FrameMaker::settle(double time_s, const PlayControls& controls, double longest_s) {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                         std::chrono::duration<double>(longest_s));
    for (int frame = 0; frame < scene_.simulation.window_frames(); ++frame) {
        if (std::chrono::steady_clock::now() >= end) return;
        propagate(time_s, controls);
    }
}

/// The newest response of a source as it is to be heard.
SourceSound FrameMaker::sound_of(std::size_t source, const PlayControls& controls) {
    const EnergyResponse& energy = propagation_.response(source);
    ImpulseResponse& response = responses_[source];
    impulse_responses_.build(energy, response);
    const float wet = controls.wet_gain();
    if (const float late = controls.late ? wet : 0; late != 1) {
        for (std::vector<float>& channel : response.channels)
            for (float& sample : channel) sample *= late;
    }
    SourceSound sound =
        source_sound(response, static_cast<double>(energy.speed_of_sound_m_s),
                     controls.source(source).gain_db.value_or(scene_.sources[source].gain_db));
    if (!controls.heard(source)) sound.gain = 0;
    const auto scale = [](DiscretePath& path, float gain) {
        for (float& band : path.band_gain) band *= gain;
    };
    if (sound.direct) scale(*sound.direct, controls.dry_gain());
    for (DiscretePath& path : sound.early) scale(path, controls.early ? wet : 0);
    return sound;
}

void FrameMaker::fill(double time_s, const PlayControls& controls, RenderFrame& frame) {
    propagate(time_s, controls);
    for (std::size_t s = 0; s < scene_.sources.size(); ++s) sounds_[s] = sound_of(s, controls);
    builder_.prepare(sounds_, head_rotation(controls.listener_at(scene_, time_s)), frame);
}

}  // namespace aula
