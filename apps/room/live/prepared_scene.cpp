#include "apps/room/live/prepared_scene.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "apps/room/auralizer/auralizer_options.h"
#include "apps/room/base/output_resources.h"
#include "apps/room/frames/ray_budget.h"
#include "apps/room/live/growing_length.h"

namespace aula {

namespace {

bool plays_the_same(const Source& a, const Source& b) {
    return a.name == b.name && a.signal == b.signal && a.signal_file == b.signal_file &&
           a.loop == b.loop;
}

SignalSet signals_of(const Scene& scene, double sample_rate_hz, const Reusable& before) {
    SharedSignals files(scene, sample_rate_hz);
    SignalSet signals;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const bool kept =
            s < before.sources.size() && plays_the_same(before.sources[s], scene.sources[s]);
        signals.push_back(kept ? before.signals[s] : files.read(s));
    }
    return signals;
}

/// Reading an HRTF takes almost a second.
std::shared_ptr<const Hrtf> hrtf_after(const PlaybackOptions& options, const Reusable& before) {
    const bool kept = before.hrtf && options.hrtf == before.options.hrtf &&
                      options.output == before.options.output &&
                      options.sample_rate_hz == before.options.sample_rate_hz;
    return kept ? before.hrtf : hrtf_for(options);
}

Scene with_length(Scene scene, const PlaybackOptions& options,
                  std::optional<double> room_length_s) {
    if (room_length_s)
        scene.simulation.ir_length_s = static_cast<float>(std::min(
            *room_length_s, options.longest_response_s.value_or(first_length_s(*room_length_s))));
    return scene;
}

std::unique_ptr<ScenePlayback> make_playback(const PreparedScene& prepared) {
    const PlaybackOptions& options = prepared.options;
    auto auralizer = std::make_unique<LiveAuralizer>(
        prepared.scene, auralizer_options(prepared.scene, options), prepared.hrtf);
    const Timeline timeline =
        live_timeline({.scene = prepared.scene,
                       .signals = prepared.signals,
                       .sample_rate_hz = options.sample_rate_hz,
                       .response_length_s = auralizer->room().heard_length_s(),
                       .duration_s = options.duration_s});
    return std::make_unique<ScenePlayback>(std::move(auralizer), prepared.signals, timeline,
                                           options.block, prepared.start);
}

}  // namespace

PreparedScene::PreparedScene(const Scene& scene_in, const PlaybackOptions& options_in,
                             bool starts_anew_in, const Reusable& before)
    : room_length_s(aula::room_length_s(scene_in)),
      scene(with_length(scene_in, options_in, room_length_s)),
      options(options_in),
      starts_anew(starts_anew_in),
      start(before.start + (starts_anew ? 1 : 0)),
      signals(signals_of(scene, options.sample_rate_hz, before)),
      hrtf(hrtf_after(options, before)),
      playback(make_playback(*this)),
      auralizer(playback->auralizer()),
      timeline(playback->timeline()),
      other_signals(playback->signals()),
      sources(auralizer.room().sources()) {}

void PreparedScene::apply(const PlayControls& controls, double time_s, bool with_listener) {
    Auralizer& room = auralizer.room();
    for (std::size_t s = 0; s < sources.size(); ++s) {
        const SourceControl control = controls.source(s);
        room.set_source(sources[s], controls.source_at(scene, s, time_s));
        room.set_gain(sources[s], controls.audible(s)
                                      ? control.gain_db.value_or(scene.sources[s].gain_db)
                                      : -std::numeric_limits<float>::infinity());
    }
    for (std::size_t o = 0; o < scene.objects.size(); ++o)
        if (scene.objects[o].path) room.set_transform(o, scene.objects[o].transform_at(time_s));
    if (with_listener || !controls.listener) room.set_listener(controls.listener_at(scene, time_s));
    room.set_part_gains({.direct = controls.dry_gain(),
                         .early = controls.early ? controls.wet_gain() : 0,
                         .late = controls.late ? controls.wet_gain() : 0});
    if (controls.frame_share)
        room.set_frame_share(*controls.frame_share);
    else
        room.set_rays(std::clamp(controls.rays.value_or(live_rays(scene.simulation)), 1,
                                 Simulation::kMaxRays));
}

void PreparedScene::take_signals(const PreparedScene& before) {
    if (before.options.sample_rate_hz != options.sample_rate_hz) return;
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
