#include "engine/mesh/mesh_import.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/mesh/mesh_readers.h"
#include "process/regular_file.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

constexpr char kMark = '#';  // between a model and the number of its sound

/// The extension in lower case, with its dot.
std::string extension_of(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

[[noreturn]] void refuse_type(const std::string& extension) {
    throw InputError("files of the type " + quoted(extension) +
                     " are not read; expected OBJ, glTF, GLB, PLY or STL");
}

}  // namespace

bool is_gltf_file(const std::filesystem::path& file) {
    const std::string extension = extension_of(file);
    return extension == ".gltf" || extension == ".glb";
}

bool is_mesh_file(const std::filesystem::path& file) {
    const std::string extension = extension_of(file);
    return is_gltf_file(file) || extension == ".obj" || extension == ".ply" || extension == ".stl";
}

fs::path SoundInModel::name() const { return model.string() + kMark + std::to_string(number); }

std::optional<SoundInModel> SoundInModel::of_name(const fs::path& name) {
    const std::string text = name.string();
    const std::size_t mark = std::min(text.rfind(kMark), text.size());
    SoundInModel sound{text.substr(0, mark)};
    if (mark == text.size() || !is_gltf_file(sound.model)) return std::nullopt;
    const char* const end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data() + mark + 1, end, sound.number);
    if (error != std::errc() || last != end) return std::nullopt;
    return sound;
}

std::string SoundInModel::read() const {
    try {
        return read_gltf_sound(read_regular_file(model, kMaxMeshBytes, "a model"), number,
                               [&](const fs::path& buffer) {
                                   return read_regular_file(model.parent_path() / buffer,
                                                            kMaxMeshBytes, "a buffer");
                               });
    } catch (const InputError& reason) {
        throw InputError(name().string() + ": " + reason.what());
    }
}

ImportedMesh import_mesh(const std::filesystem::path& file) {
    const std::string extension = extension_of(file);
    std::vector<std::filesystem::path> files;
    const auto bytes = [&](const std::filesystem::path& part) {
        std::string all = read_regular_file(part, kMaxMeshBytes, "a mesh file");
        files.push_back(part);
        return all;
    };
    ImportedMesh mesh;
    if (extension == ".obj") {
        mesh = read_obj(bytes(file));
    } else if (extension == ".ply") {
        mesh = read_ply(bytes(file));
    } else if (extension == ".stl") {
        mesh = read_stl(bytes(file));
    } else if (is_gltf_file(file)) {
        mesh = read_gltf(bytes(file), [&](const std::filesystem::path& buffer) {
            return bytes(file.parent_path() / buffer);
        });
    } else {
        refuse_type(extension);
    }
    mesh.files = std::move(files);
    return mesh;
}

}  // namespace aula
