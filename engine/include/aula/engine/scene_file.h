#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "aula/engine/scene.h"
#include "aula/exception.h"

namespace aula {

struct JsonValue;

/// All errors of a scene that can be found after the first one; what() is the first message. A
/// syntax error is the only one of its file.
class SceneErrors : public InputError {
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
    /// The file's content; geometry[i] is scene.objects[i].
    std::shared_ptr<const JsonValue> json;
};

/// Reads a scene file (JSON with comments, docs/scene_format.md) with its meshes. File names in it
/// are relative to it. Sound files are checked to exist, not read. Throws SceneErrors, or
/// InputError if the file is not valid JSON.
LoadedScene load_scene(const std::filesystem::path& file);

}  // namespace aula
