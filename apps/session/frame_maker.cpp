#include "apps/session/frame_maker.h"

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

void FrameMaker::fill(double time_s, const Pose& listener, RenderFrame& frame) {
    input_.time_s = time_s;
    input_.listeners[0] = listener.position;
    for (std::size_t s = 0; s < scene_.sources.size(); ++s)
        input_.sources[s] = scene_.sources[s].position_at(time_s);
    propagation_.step(input_);
    for (std::size_t s = 0; s < scene_.sources.size(); ++s) {
        const EnergyResponse& energy = propagation_.response(s);
        impulse_responses_.build(energy, responses_[s]);
        sounds_[s] = source_sound(responses_[s], static_cast<double>(energy.speed_of_sound_m_s),
                                  scene_.sources[s].gain_db);
    }
    builder_.prepare(sounds_, head_rotation(listener), frame);
}

}  // namespace aula
