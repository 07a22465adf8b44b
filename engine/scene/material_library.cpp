#include "aula/engine/material_library.h"

#include <algorithm>

#include "engine/input/json_reader.h"
#include "engine/scene/scene_values.h"

namespace aula {

extern const char* const kMaterialsJson;  // engine/scene/materials.json, embedded by the build

std::vector<LibraryMaterial> material_library() {
    const std::string file = "materials.json";
    const JsonValue json = parse_json(kMaterialsJson, file);
    std::vector<LibraryMaterial> library;
    for (const auto& [name, entry] : JsonReader(json, file).members("an object of materials")) {
        library.push_back({read_material(name, entry),
                           entry.require("source", "where the values come from").string("a text")});
    }
    std::sort(library.begin(), library.end(),
              [](const auto& a, const auto& b) { return a.material.name < b.material.name; });
    return library;
}

}  // namespace aula
