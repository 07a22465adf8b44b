#include "apps/session/live/prepared_scene.h"

#include <algorithm>

namespace aula {

namespace {

bool plays_the_same(const Source& a, const Source& b) {
    return a.name == b.name && a.signal == b.signal && a.signal_file == b.signal_file &&
           a.loop == b.loop;
}

SignalSet signals_of(const Scene& scene, double sample_rate_hz, const Reusable& before) {
    SignalSet signals;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const bool kept =
            s < before.sources.size() && plays_the_same(before.sources[s], scene.sources[s]);
        signals.push_back(kept ? before.signals[s] : read_signal(scene, s, sample_rate_hz));
    }
    return signals;
}

/// Reading an HRTF takes most of a second.
std::shared_ptr<const Hrtf> hrtf_after(const SessionOptions& options, double sample_rate_hz,
                                       const Reusable& before) {
    const bool kept = before.hrtf && options.hrtf == before.options.hrtf &&
                      options.output == before.options.output;
    return kept ? before.hrtf : hrtf_for(options, sample_rate_hz);
}

Scene with_length(Scene scene, const SessionOptions& options) {
    if (!scene.simulation.ir_length_s && options.longest_response_s)
        scene.simulation.ir_length_s = static_cast<float>(*options.longest_response_s);
    return scene;
}

}  // namespace

PreparedScene::PreparedScene(const Scene& scene_in, const SessionOptions& options_in,
                             double sample_rate_hz, bool starts_anew_in, const Reusable& before)
    : length_given(scene_in.simulation.ir_length_s.has_value()),
      scene(with_length(scene_in, options_in)),
      options(options_in),
      starts_anew(starts_anew_in),
      signals(signals_of(scene, sample_rate_hz, before)),
      hrtf(hrtf_after(options, sample_rate_hz, before)),
      maker(scene, frame_settings(options, sample_rate_hz), hrtf),
      timeline(live_timeline({.scene = scene,
                              .signals = signals,
                              .sample_rate_hz = sample_rate_hz,
                              .response_length_s = maker.response_length_s(),
                              .duration_s = options.duration_s})),
      playback(
          std::make_unique<ScenePlayback>(maker.config(), signals, timeline, hrtf, starts_anew)),
      frames(playback->frames()),
      other_signals(playback->signals()) {}

void PreparedScene::take_signals(const PreparedScene& before) {
    bool differs = false;
    for (std::size_t s = 0; s < std::min(signals.size(), before.signals.size()); ++s) {
        if (signals[s] == before.signals[s] ||
            !plays_the_same(before.scene.sources[s], scene.sources[s]))
            continue;
        signals[s] = before.signals[s];
        differs = true;
    }
    if (differs) other_signals.publish(std::make_unique<SignalSet>(signals));
}

}  // namespace aula
