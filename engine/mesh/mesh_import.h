#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aula/engine/vec3.h"
#include "engine/input/json.h"

namespace aula {

/// A place in a model that stands for a source or the listener.
struct ImportedPlace {
    enum class Kind { source, listener };

    Kind kind = Kind::source;
    std::string name;        ///< of its node
    Vec3 position{0};        ///< in the axes and units of the file
    Vec3 front{0};           ///< where it looks; not normalized
    double gain = 1;         ///< linear
    std::string guessed_by;  ///< the word of its name, if that alone makes it a place
    bool loop = false;       ///< whether the sound is repeated
    std::string sound;       ///< a file beside the model; empty: none
    std::optional<std::size_t> sound_inside;  ///< SoundInModel::number
    std::string sound_type;  ///< of the sound inside, such as "audio/mpeg"; may be empty
};

/// The beginning of a sound inside a model.
struct SoundBeginning {
    static constexpr std::size_t kBytes = 4;

    std::string bytes;  ///< kBytes, or fewer of a shorter sound
    std::string error;  ///< why it cannot be read; empty: it can
};

/// The triangles of a mesh file with node transforms applied, in the axes and units of the file.
/// Triangles without area, points and lines are omitted.
struct ImportedMesh {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> triangle_materials;  ///< index into material_names
    std::vector<std::string> material_names;        ///< as in the file, each once
    std::vector<std::filesystem::path> files;       ///< all files read

    // Only glTF has these.
    std::string scene;                     ///< the name of the one that is read
    std::size_t scene_count = 0;           ///< of the file
    std::size_t global_emitter_count = 0;  ///< sounds of the scene that have no place
    std::vector<ImportedPlace> places;
    std::vector<std::string> shapes_of_sources;  ///< names of sources that are shapes, not places
    std::map<std::size_t, SoundBeginning> sounds_inside;  ///< of places, by SoundInModel::number
    /// The "extras" of materials by their names: an object, or nothing.
    std::vector<std::pair<std::string, JsonValue>> material_extras;
};

/// Limits of a mesh file.
inline constexpr std::uint64_t kMaxMeshBytes = std::uint64_t{1} << 30;
inline constexpr std::uint64_t kMaxMeshTriangles = 20'000'000;

/// The material name of faces without one.
inline constexpr const char* kNamelessMaterial = "DefaultMaterial";

/// Whether the file's extension is that of OBJ, glTF, GLB, PLY or STL, in any case; of glTF or GLB.
bool is_mesh_file(const std::filesystem::path& file);
bool is_gltf_file(const std::filesystem::path& file);

/// A sound inside a glTF file, by its number in the "audio" of KHR_audio_emitter.
struct SoundInModel {
    std::filesystem::path model;
    std::size_t number = 0;

    /// Its name in scene files: "room.glb#0".
    std::filesystem::path name() const;
    /// The sound of that name; empty if it is the name of a file.
    static std::optional<SoundInModel> of_name(const std::filesystem::path& name);
    /// The bytes of its file. Throws InputError.
    std::string read() const;
};

/// Reads OBJ, glTF, GLB, PLY or STL according to the file's extension. The file may be malicious:
/// its size is bounded, all indices are checked and reading never blocks. Throws InputError with
/// the message "what is wrong; what was expected".
ImportedMesh import_mesh(const std::filesystem::path& file);

}  // namespace aula
