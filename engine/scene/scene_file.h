#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/input/json.h"
#include "engine/scene/scene.h"

namespace aula {

/// What is wrong with a scene, all of it that can be said after the first error; what() is the
/// first message. A syntax error is the only one of its file.
class SceneErrors : public Error {
 public:
    /// At least one message.
    explicit SceneErrors(std::vector<std::string> messages);

    const std::vector<std::string>& messages() const { return messages_; }

 private:
    std::vector<std::string> messages_;
};

struct LoadedScene {
    Scene scene;
    std::vector<std::string> warnings;  ///< each a line for the user, without "aula: warning:"
    bool rays_given = false;            ///< the file says how many rays
    JsonValue json;                     ///< the file's content; geometry[i] is scene.objects[i]
};

/// Reads a scene file (JSON with comments, docs/scene_format.md) with its meshes. Files inside it
/// are relative to it. Sound files are checked to exist, not read. Throws
/// SceneErrors, or Error where it cannot be read as JSON.
LoadedScene load_scene(const std::filesystem::path& file);

}  // namespace aula
