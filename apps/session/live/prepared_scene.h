#pragma once

#include <memory>
#include <vector>

#include "apps/session/base/session_options.h"
#include "apps/session/frames/play_controls.h"
#include "apps/session/live/live_mixer.h"
#include "aula/engine/scene.h"

namespace aula {

/// What takes long to read and is kept when something else is played.
struct Reusable {
    std::vector<Source> sources;
    SignalSet signals;  ///< of the sources
    SessionOptions options;
    std::shared_ptr<const Hrtf> hrtf;
};

/// A scene ready to be played: its auralizer, signals and timeline. Prepared on any thread. The
/// playback goes to the mixer; the references are valid while it exists.
struct PreparedScene {
    /// Reads sound files and HRTF unless `before` has them; builds the engine and the renderer.
    /// Throws InputError.
    PreparedScene(const Scene& scene, const SessionOptions& options, double sample_rate_hz,
                  bool starts_anew, const Reusable& before = {});

    /// Gives the auralizer the state of the scene with these controls at a time. The pose of a
    /// listener that the user has set reaches it by set_listener() alone, so that no older one
    /// follows a newer; `with_listener` includes it.
    void apply(const PlayControls& controls, double time_s, bool with_listener = false);

    /// Continues with the present signals of another prepared scene on sources that are the same.
    void take_signals(const PreparedScene& before);

    Reusable reusable() const { return {scene.sources, signals, options, hrtf}; }

    bool length_given;  ///< the scene sets the length of responses
    Scene scene;
    SessionOptions options;
    bool starts_anew;   ///< its time begins when it does; otherwise the time played continues
    double zero_s = 0;  ///< of the time played, where the scene's time begins
    SignalSet signals;
    std::shared_ptr<const Hrtf> hrtf;
    std::unique_ptr<ScenePlayback> playback;  ///< until the mixer has it
    LiveAuralizer& auralizer;                 ///< of the playback
    Timeline timeline;                        ///< of the playback
    Mailbox<SignalSet>& other_signals;        ///< of the playback
    std::vector<SourceId> sources;            ///< in the order of the scene's
};

}  // namespace aula
