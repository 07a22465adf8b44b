#include "aula/devices/scene_player.h"

#include <algorithm>
#include <atomic>

#include "apps/room/auralizer/command_checks.h"
#include "apps/room/live/player.h"

namespace aula {

namespace {

PlaybackOptions playback_options(const ScenePlayerOptions& options) {
    PlaybackOptions playback{options};
    playback.duration_s = options.duration_s;
    playback.device = options.device;
    playback.rays_fall = options.reduces_rays;
    return playback;
}

}  // namespace

struct ScenePlayer::State {
    State(const Scene& scene, const PlaybackOptions& playback)
        : options(playback), sources(scene.sources.size()), player(scene, playback) {}

    /// Changes the controls of a source.
    template <typename Change>
    void change_source(std::size_t source, const Change& change) {
        require(source < sources, "there is no source with this index");
        player.adjust([&](PlayControls& controls, const Pose&) {
            if (controls.sources.size() <= source) controls.sources.resize(source + 1);
            change(controls.sources[source]);
        });
    }

    const PlaybackOptions options;
    std::atomic<std::size_t> sources;  ///< of the scene with the most sources
    Player player;
};

ScenePlayer::ScenePlayer(const Scene& scene, const ScenePlayerOptions& options)
    : state_(std::make_unique<State>(scene, playback_options(options))) {}

ScenePlayer::~ScenePlayer() = default;

void ScenePlayer::set_listener(const Pose& pose) {
    check_pose(pose);
    state_->player.adjust([&](PlayControls& controls, const Pose&) { controls.listener = pose; });
}

void ScenePlayer::set_source(std::size_t source, const Vec3& position) {
    check_position(position);
    state_->change_source(source, [&](SourceControl& control) { control.position = position; });
}

void ScenePlayer::set_gain(std::size_t source, float gain_db) {
    check_gain(gain_db);
    state_->change_source(source, [&](SourceControl& control) { control.gain_db = gain_db; });
}

std::uint64_t ScenePlayer::change(const Scene& scene, bool starts_anew) {
    const std::uint64_t number = state_->player.change(scene, state_->options, starts_anew);
    state_->sources = std::max(state_->sources.load(), scene.sources.size());
    return number;
}

ScenePlayerStatus ScenePlayer::status() { return state_->player.status(); }

const DeviceInfo& ScenePlayer::device() const { return state_->player.device(); }

}  // namespace aula
