#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "aula/engine/scene.h"
#include "aula/exception.h"

namespace aula {

struct JsonValue;

/// The errors of a scene file. Reading continues after an error as far as possible, so that all
/// errors are found together. what() is the first message.
class SceneErrors : public InputError {
 public:
    /// `messages` has at least one element.
    explicit SceneErrors(std::vector<std::string> messages);

    /// One line for each error, as InputError describes it.
    const std::vector<std::string>& messages() const { return messages_; }

 private:
    std::vector<std::string> messages_;
};

/// A scene that was read from a file.
struct LoadedScene {
    Scene scene;                        ///< the content, with the meshes
    std::vector<std::string> warnings;  ///< one line each, such as a source outside the geometry
    std::vector<std::string> guesses;   ///< of a mesh file; each is in a warning, too
    /// The file's JSON, for programs that write it again; its type is internal. Element i of
    /// "geometry" is scene.objects[i].
    std::shared_ptr<const JsonValue> json;
};

/// Whether the sound files of the sources have to exist. They are not read with the scene.
enum class SignalFiles { required, optional };

/// Reads a scene file (JSON with comments, docs/scene_format.md) with its meshes. File names in it
/// are relative to its folder. A mesh file (.obj, .gltf, .glb, .ply, .stl) is a scene, too: what it
/// does not say is guessed (docs/from_model_to_sound.md), and each guess is a warning. Throws
/// SceneErrors for wrong content, and InputError if the file cannot be read or is not valid JSON.
LoadedScene load_scene(const std::filesystem::path& file,
                       SignalFiles signals = SignalFiles::required);

/// Reads a scene from the text of a scene file, as load_scene(). `name` is the file's name in
/// messages. File names in the text are relative to `folder`.
LoadedScene parse_scene(const std::string& text, const std::string& name,
                        const std::filesystem::path& folder,
                        SignalFiles signals = SignalFiles::required);

}  // namespace aula
