#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "apps/room/base/playback_options.h"
#include "apps/room/frames/play_controls.h"
#include "apps/room/live/live_mixer.h"
#include "aula/engine/scene.h"

namespace aula {

/// Data that take long to read and are reused by the next playback.
struct Reusable {
    std::vector<Source> sources;
    SignalSet signals;  ///< of the sources
    PlaybackOptions options;
    std::shared_ptr<const Hrtf> hrtf;
    std::uint64_t start = 0;  ///< number of the start of the signals
};

/// A scene ready to be played: its auralizer, signals and timeline. Prepared on any thread. The
/// playback goes to the mixer; the references are valid while it exists.
struct PreparedScene {
    /// Reads sound files and HRTF unless `before` has them; builds the engine and the renderer.
    /// Throws InputError.
    PreparedScene(const Scene& scene, const PlaybackOptions& options, bool starts_anew,
                  const Reusable& before = {});

    /// Gives the auralizer the state of the scene with these controls at a time. A listener's pose
    /// from the user is passed by set_listener() only, so that no older pose follows a newer one;
    /// `with_listener` includes it.
    void apply(const PlayControls& controls, double time_s, bool with_listener = false);

    /// Continues the present signals of another prepared scene on equal sources, if the sample
    /// rates are equal.
    void take_signals(const PreparedScene& before);

    Reusable reusable() const { return {scene.sources, signals, options, hrtf, start}; }

    std::optional<double> room_length_s;  ///< as long as the room sounds; empty if the scene sets
                                          ///< the length of the responses
    Scene scene;
    PlaybackOptions options;
    bool starts_anew;     ///< its time begins with it; otherwise the played time continues
    std::uint64_t start;  ///< number of the scene's start, see ScenePlayback
    double zero_s = 0;    ///< played time at which the scene's time begins
    SignalSet signals;
    std::shared_ptr<const Hrtf> hrtf;
    std::unique_ptr<ScenePlayback> playback;  ///< until it is passed to the mixer
    LiveAuralizer& auralizer;                 ///< of the playback
    Timeline timeline;                        ///< of the playback
    Mailbox<SignalSet>& other_signals;        ///< of the playback
    std::vector<SourceId> sources;            ///< in the order of the scene's
};

}  // namespace aula
