#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/input/json.h"
#include "engine/scene/scene.h"

namespace aula {

/// All errors of a scene that can be found after the first one; what() is the first message. A
/// syntax error is the only one of its file.
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
    bool rays_given = false;            ///< the file sets the number of rays
    JsonValue json;                     ///< the file's content; geometry[i] is scene.objects[i]
};

/// Reads a scene file (JSON with comments, docs/scene_format.md) with its meshes. File names in it
/// are relative to it. Sound files are checked to exist, not read. Throws SceneErrors, or Error if
/// the file is not valid JSON.
LoadedScene load_scene(const std::filesystem::path& file);

}  // namespace aula
