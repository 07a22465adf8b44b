#include "apps/room/live/prepared_scene.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "apps/room/auralizer/auralizer_options.h"
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

Scene with_length(Scene scene, const PlaybackOptions& options,
                  std::optional<double> room_length_s) {
    if (room_length_s)
        scene.simulation.ir_length_s = static_cast<float>(std::min(
            *room_length_s, options.longest_response_s.value_or(first_length_s(*room_length_s))));
    return scene;
}

std::unique_ptr<LiveAuralizer> auralizer_for(const Scene& scene, const PlaybackOptions& options,
                                             const Reusable& before) {
    if (before.auralizer != nullptr && before.options.sample_rate_hz == options.sample_rate_hz)
        return nullptr;
    return std::make_unique<LiveAuralizer>(scene, auralizer_options(scene, options));
}

std::shared_ptr<BuiltRoom> built_for(const PreparedScene& prepared, const Reusable& before) {
    if (prepared.auralizer) return prepared.auralizer->first();
    return before.auralizer->build(prepared.scene,
                                   auralizer_options(prepared.scene, prepared.options));
}

ScenePlayback& with_playback(const PreparedScene& prepared) {
    auto playback = std::make_unique<ScenePlayback>(prepared.signals, prepared.timeline,
                                                    prepared.options.sample_rate_hz,
                                                    prepared.options.block, prepared.start);
    ScenePlayback& made = *playback;
    prepared.built->sounding->signals = std::move(playback);
    return made;
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
      auralizer(auralizer_for(scene, options, before)),
      built(built_for(*this, before)),
      timeline(live_timeline({.scene = scene,
                              .signals = signals,
                              .sample_rate_hz = options.sample_rate_hz,
                              .response_length_s = built->heard_length_s(),
                              .duration_s = options.duration_s})),
      playback(with_playback(*this)) {}

RoomState PreparedScene::state(const PlayControls& controls, double time_s) const {
    RoomState state = room_state(scene, time_s);
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        SourceState& source = state.sources[s];
        source.pose = controls.source_at(scene, s, time_s);
        source.gain_db = controls.source(s).gain_db.value_or(source.gain_db);
        if (!controls.audible(s)) source.gain_db = -std::numeric_limits<float>::infinity();
    }
    for (const Object& object : scene.objects) state.objects.push_back(object.transform_at(time_s));
    state.listeners = {controls.listener_at(scene, time_s)};
    state.direct_gain = controls.dry_gain();
    state.early_gain = controls.early ? controls.wet_gain() : 0;
    state.late_gain = controls.late ? controls.wet_gain() : 0;
    state.rays =
        std::clamp(controls.rays.value_or(live_rays(scene.simulation)), 1, Simulation::kMaxRays);
    state.frame_share = controls.frame_share;
    return state;
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
    if (differs) playback.signals().publish(std::make_unique<SignalSet>(signals));
}

}  // namespace aula
