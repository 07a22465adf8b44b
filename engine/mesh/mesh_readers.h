#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "engine/mesh/mesh_import.h"

namespace aula {

// Readers of mesh files from the bytes of a whole file. The bytes need not be valid. All throw
// InputError with the message "what is wrong; what was expected".

/// Wavefront OBJ: v, f and usemtl. MTL files are not opened.
ImportedMesh read_obj(std::string_view bytes);

/// PLY 1.0, as text or binary in both byte orders: x, y, z and the vertex lists of faces.
ImportedMesh read_ply(std::string_view bytes);

/// STL, as text or binary.
ImportedMesh read_stl(std::string_view bytes);

/// Returns the bytes of a buffer's file, whose name is relative to the glTF file. Throws
/// InputError.
using OpenBuffer = std::function<std::string(const std::filesystem::path&)>;

/// glTF 2.0 as JSON or GLB: the nodes of the scene and their triangles, strips and fans. Images and
/// skins are ignored; compressed triangles are an error.
ImportedMesh read_gltf(std::string_view bytes, const OpenBuffer& open);

/// The bytes of a sound that is inside a glTF file: the one with that number in the "audio" of
/// KHR_audio_emitter.
std::string read_gltf_sound(std::string_view bytes, std::size_t number, const OpenBuffer& open);

}  // namespace aula
