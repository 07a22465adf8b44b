#include "apps/session/frames/frame_maker.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/session/frames/ray_budget.h"
#include "apps/session/frames/sound_at_listener.h"

namespace aula {

FrameMaker::FrameMaker(const Scene& scene, double sample_rate_hz, const SessionOptions& options,
                       std::shared_ptr<const Hrtf> hrtf)
    : scene_(scene),
      propagation_(scene, scene.simulation),
      config_(renderer_config(scene, propagation_.response_length_s(), sample_rate_hz, options)),
      builder_(config_, std::move(hrtf)),
      rays_(scene.simulation.rays),
      responses_(scene.sources.size()),
      sounds_(scene.sources.size()) {
    input_.sources.resize(scene.sources.size());
    input_.listeners.resize(1);
    const auto carriers =
        std::make_shared<const NoiseCarriers>(sample_rate_hz, scene.simulation.seed);
    for (const Source& source : scene.sources)
        impulse_responses_.emplace_back(carriers, propagation_.response_length_s(), source.name,
                                        field_order(config_));
}

int FrameMaker::rays_wanted(const PlayControls& controls) const {
    if (controls.frame_share && frame_s_ > 0)
        return rays_within_budget(rays_, statistics(), frame_s_,
                                  *controls.frame_share * config_.frame_s);
    return controls.rays.value_or(scene_.simulation.rays);
}

void FrameMaker::propagate(double time_s, const PlayControls& controls) {
    if (const int wanted = rays_wanted(controls); wanted != rays_) {
        propagation_.set_rays(wanted);
        rays_ = wanted;
    }
    listener_ = controls.listener_at(scene_, time_s);
    input_.time_s = time_s;
    input_.listeners[0] = listener_.position;
    for (std::size_t s = 0; s < scene_.sources.size(); ++s)
        input_.sources[s] =
            controls.source(s).position.value_or(scene_.sources[s].position_at(time_s));
    propagation_.step(input_);
}

void FrameMaker::warm_up(double time_s, const PlayControls& controls, double longest_s) {
    const auto end = std::chrono::steady_clock::now() +
                     std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                         std::chrono::duration<double>(longest_s));
    for (int frame = 0; frame < scene_.simulation.window_frames(); ++frame) {
        if (std::chrono::steady_clock::now() >= end) break;
        propagate(time_s, controls);
    }
    // A builder's first response takes longer than others.
    for (std::size_t s = 0; s < scene_.sources.size(); ++s)
        impulse_responses_[s].build(propagation_.response(s), responses_[s]);
}

/// The newest response of a source as it is to be heard.
SourceSound FrameMaker::sound_of(std::size_t source, const PlayControls& controls) {
    const EnergyResponse& energy = propagation_.response(source);
    ImpulseResponse& response = responses_[source];
    impulse_responses_[source].build(energy, response);
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
    const auto begin = std::chrono::steady_clock::now();
    propagate(time_s, controls);
    for (std::size_t s = 0; s < scene_.sources.size(); ++s) sounds_[s] = sound_of(s, controls);
    builder_.prepare(sounds_, frame);
    frame_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

FrameView FrameMaker::view(const ViewRequest& request) const {
    FrameView view;
    if (scene_.sources.empty()) return view;
    view.source = std::min(request.source, scene_.sources.size() - 1);
    view.listener = listener_;
    view.sources = input_.sources;
    view.simulation = scene_.simulation;
    view.simulation.rays = rays_;
    view.response = propagation_.response(view.source);
    view.length_s = response_length_s();
    view.impulse_response.assign(request.columns, 0);
    const std::vector<float>& pressure = responses_[view.source].channels[0];
    for (std::size_t i = 0; i < pressure.size(); ++i) {
        float& column = view.impulse_response[i * request.columns / pressure.size()];
        column = std::max(column, std::abs(pressure[i]));
    }
    if (request.lines > 0)
        view.lines =
            propagation_.path_lines(input_, view.source, request.lines, request.line_order);
    if (request.patches)
        view.patches = propagation_.patch_energies(view.source, request.patches_begin_s,
                                                   request.patches_end_s);
    view.patch_size_m = propagation_.patch_size_m();
    return view;
}

}  // namespace aula
