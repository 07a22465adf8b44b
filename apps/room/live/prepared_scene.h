#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "apps/room/base/playback_options.h"
#include "apps/room/frames/play_controls.h"
#include "apps/room/frames/room_state.h"
#include "apps/room/live/live_mixer.h"
#include "aula/engine/scene.h"

namespace aula {

/// What the next scene takes from the one that plays.
struct Reusable {
    std::vector<Source> sources;
    SignalSet signals;  ///< of the sources; reading them takes long
    PlaybackOptions options;
    std::uint64_t start = 0;             ///< number of the start of the signals
    LiveAuralizer* auralizer = nullptr;  ///< that plays scenes of this sample rate; null: none
};

/// A scene ready to be played, with its signals and its timeline. Prepared on any thread.
struct PreparedScene {
    /// Reads sound files unless `before` has them, and builds the scene for the auralizer of
    /// `before`, or an auralizer if that one is missing or has another sample rate. Throws
    /// InputError.
    PreparedScene(const Scene& scene, const PlaybackOptions& options, bool starts_anew,
                  const Reusable& before = {});

    /// The state of the scene with these controls at a time.
    RoomState state(const PlayControls& controls, double time_s) const;

    /// Continues the present signals of another prepared scene on equal sources, if the sample
    /// rates are equal.
    void take_signals(const PreparedScene& before);

    double response_length_s() const { return built->computer.response_length_s(); }

    std::optional<double> room_length_s;  ///< as long as the room sounds; empty if the scene sets
                                          ///< the length of the responses
    Scene scene;
    PlaybackOptions options;
    bool starts_anew;          ///< its time begins with it; otherwise the played time continues
    std::uint64_t start;       ///< number of the scene's start, see ScenePlayback
    double zero_s = 0;         ///< played time at which the scene's time begins
    std::uint64_t number = 0;  ///< of the scene in its auralizer, once it is to begin
    SignalSet signals;
    std::unique_ptr<LiveAuralizer> auralizer;  ///< that begins with the scene, or null
    std::shared_ptr<BuiltRoom> built;          ///< of this auralizer or of the present one
    Timeline timeline;
    ScenePlayback& playback;  ///< of the sound of the scene; valid while frames of it are computed
};

}  // namespace aula
