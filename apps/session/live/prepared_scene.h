#pragma once

#include <memory>
#include <vector>

#include "apps/session/base/session_options.h"
#include "apps/session/frames/frame_maker.h"
#include "apps/session/live/live_mixer.h"
#include "aula/engine/scene.h"

namespace aula {

/// What takes long to read and may go on when something else is played.
struct Reusable {
    std::vector<Source> sources;
    SignalSet signals;  ///< of the sources
    SessionOptions options;
    std::shared_ptr<const Hrtf> hrtf;
};

/// A scene ready to be played: what makes its frames, and the playback that plays them. Prepared on
/// any thread, then used by the propagation thread; the playback goes to the mixer.
struct PreparedScene {
    /// Reads sound files and HRTF unless `before` has them; builds the engine and the renderer.
    /// Throws InputError.
    PreparedScene(const Scene& scene, const SessionOptions& options, double sample_rate_hz,
                  bool starts_anew, const Reusable& before = {});

    /// Plays on what another prepared scene plays by now on sources that are the same.
    void take_signals(const PreparedScene& before);

    Reusable reusable() const { return {scene.sources, signals, options, hrtf}; }

    bool length_given;  ///< the scene's response is as long as was asked for
    Scene scene;
    SessionOptions options;
    bool starts_anew;   ///< its time begins when it does; else it goes on from what was played
    double zero_s = 0;  ///< of the time played, where its own time begins
    SignalSet signals;
    std::shared_ptr<const Hrtf> hrtf;
    FrameMaker maker;
    Timeline timeline;
    std::unique_ptr<ScenePlayback> playback;  ///< until the mixer has it
    Mailbox<RenderFrame>& frames;             ///< of the playback
    Mailbox<SignalSet>& other_signals;        ///< of the playback
};

}  // namespace aula
