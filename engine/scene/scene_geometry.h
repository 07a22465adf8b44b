#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "aula/engine/material_library.h"
#include "aula/engine/scene.h"
#include "engine/input/json_reader.h"

namespace aula {

/// The materials that a scene file can name: its own, then those that ship with Aula. A library
/// material is added to the scene at its first use.
class MaterialTable {
 public:
    /// `own` is the scene file's "materials", if present.
    explicit MaterialTable(const std::optional<JsonReader>& own);

    /// Index of a material in materials(), or empty for an unknown name.
    std::optional<std::uint32_t> find(const std::string& name);
    /// Index of the material that a string in the scene file names. Throws InputError, which lists
    /// the known names.
    std::uint32_t require(const JsonReader& name);

    /// The known names, the scene's own first.
    std::vector<std::string> names() const;

    /// `, did you mean "wood"?` for "wod" or "Holz"; empty if nothing is near or meant.
    std::string meant(const std::string& name) const;

    std::vector<Material> take() { return std::move(materials_); }

 private:
    /// The material of the scene so far, or of the library, that "like" names. Throws InputError.
    Material known(const JsonReader& like) const;
    std::uint32_t add(Material material);

    std::vector<Material> materials_;
    std::unordered_map<std::string, std::uint32_t> indices_;  // in materials_
    std::vector<LibraryMaterial> library_;
};

/// Reads one element of "geometry": a mesh file relative to `folder`, a box or inline faces. Adds
/// lines to `warnings`. Throws InputError.
Object read_object(const JsonReader& json, const std::filesystem::path& folder,
                   MaterialTable& materials, std::vector<std::string>& warnings);

}  // namespace aula
