#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/session/base/session_options.h"
#include "engine/scene/scene.h"

namespace aula {

/// A scene that can be rendered to a file or played live: engine and audio in one object.
///
///     auto loaded = aula::load_scene("room.json");
///     aula::Session session(loaded.scene, {});
///     session.render("out.wav");  // or session.play();
class Session {
 public:
    Session(Scene scene, SessionOptions options);

    /// Renders the scene to a WAV file. Sources, listener and objects follow their paths; a frame's
    /// pose takes effect at the first sample at or after its time. Returns false, and leaves no
    /// file, if `progress` requested a stop. The same scene, seed and options give the same bytes
    /// with any block size and any number of threads. Throws Error, AudioInputError, AudioFailure.
    bool render(const std::filesystem::path& file, const Progress& progress = {});

    /// Plays on the output device until the end of the scene; never returns if the scene has no
    /// end. For more control use a Player. Throws Error, AudioInputError, AudioFailure.
    void play();

    /// The warnings about sound files; complete after render() or play().
    const std::vector<std::string>& warnings() const { return warnings_; }

 private:
    Scene scene_;
    SessionOptions options_;
    std::vector<std::string> warnings_;
};

}  // namespace aula
