#include "engine/scene/scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "aula/exception.h"
#include "engine/input/material_guess.h"
#include "engine/input/names.h"
#include "engine/mesh/mesh_import.h"
#include "engine/mesh/polygon.h"
#include "engine/scene/scene_values.h"
#include "process/files.h"

namespace aula {
namespace {

constexpr const char* kFaces = "a list of faces, each a list of vertex indices";
constexpr const char* kMaterialName = "the name of a material";

// The keys that every kind of geometry accepts.
std::vector<std::string> with_common_keys(std::vector<std::string> keys) {
    keys.insert(keys.end(), {"name", "material", "surfaces", "up", "scale", "translate", "path"});
    return keys;
}

void set_single_material(Object& object, std::uint32_t material) {
    object.triangle_materials.assign(object.triangles.size(), material);
}

// Reads the "material" of all triangles.
void read_single_material(const JsonReader& json, MaterialTable& materials, Object& object) {
    set_single_material(object, 0);
    json.attempt([&] {
        set_single_material(object, materials.require(json.require("material", kMaterialName)));
    });
}

Object read_box(const JsonReader& json, MaterialTable& materials) {
    json.allow_keys(with_common_keys({"box", "min"}));
    Vec3 size(0);
    json.attempt([&] {
        const JsonReader size_json = json.require("box", "a list of 3 sizes in metres");
        size = read_point(size_json);
        if (!(size.x > 0 && size.y > 0 && size.z > 0)) {
            size_json.fail("a box needs three sides; expected sizes above 0");
        }
    });
    Vec3 min(0);
    json.read("min", [&](const JsonReader& x) { min = read_point(x); });

    Object object;
    for (unsigned corner = 0; corner < 8; ++corner) {
        object.vertices.push_back(min + size * Vec3((corner & 1U) != 0 ? 1 : 0,
                                                    (corner & 2U) != 0 ? 1 : 0,
                                                    (corner & 4U) != 0 ? 1 : 0));
    }
    // Bits of a corner's index are x, y and z. Counter-clockwise as seen from inside: the walls
    // face inwards.
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kWalls{
        {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}};
    for (const auto& wall : kWalls) {
        object.triangles.push_back({wall[0], wall[1], wall[2]});
        object.triangles.push_back({wall[0], wall[2], wall[3]});
    }
    read_single_material(json, materials, object);
    return object;
}

std::vector<std::uint32_t> read_face(const JsonReader& json, std::size_t vertex_count) {
    constexpr const char* kExpected = "a list of at least 3 vertex indices";
    std::vector<std::uint32_t> face;
    for (const JsonReader& item : json.items(kExpected)) {
        const std::uint64_t index = item.unsigned_integer();
        if (index >= vertex_count) {
            item.fail("index " + std::to_string(index) + " is out of range; expected 0 to " +
                      std::to_string(vertex_count - 1));
        }
        face.push_back(static_cast<std::uint32_t>(index));
    }
    if (face.size() < 3) {
        json.fail("a face of " + std::to_string(face.size()) + "; expected " + kExpected);
    }
    if (face.size() > kMaxCorners) {
        json.fail("a face of " + std::to_string(face.size()) + " corners; expected at most " +
                  std::to_string(kMaxCorners));
    }
    return face;
}

// Reads the triangles of "faces". If the vertices are not `known`, only their indices are checked.
void read_triangles(const JsonReader& faces, bool known, Object& object) {
    const std::vector<JsonReader> items = faces.items(kFaces);
    for (const JsonReader& item : items) {
        item.attempt([&] {
            const std::vector<std::uint32_t> face = read_face(item, object.vertices.size());
            if (!known) return;
            std::vector<Vec3> corners;
            for (const std::uint32_t index : face) corners.push_back(object.vertices[index]);
            const auto triangles = triangulate(corners);
            if (triangles.empty()) {
                item.fail("the face has no area or crosses itself; expected a simple polygon");
            }
            for (const auto& [a, b, c] : triangles) {
                object.triangles.push_back({face[a], face[b], face[c]});
            }
        });
    }
    if (items.empty()) faces.fail("an empty mesh; expected at least one face");
}

Object read_faces(const JsonReader& json, MaterialTable& materials) {
    json.allow_keys(with_common_keys({"vertices", "faces"}));
    Object object;
    bool known = false;
    json.attempt([&] {
        constexpr const char* kVertices = "a list of points [x, y, z]";
        const JsonReader vertices = json.require("vertices", kVertices);
        const std::vector<JsonReader> items = vertices.items(kVertices);
        if (items.empty()) vertices.fail("an empty mesh; expected at least 3 vertices");
        object.vertices.resize(items.size());
        std::size_t read = 0;
        for (std::size_t i = 0; i < items.size(); ++i) {
            items[i].attempt([&] {
                object.vertices[i] = read_point(items[i]);
                ++read;
            });
        }
        known = read == items.size();
    });
    json.attempt([&] {
        const JsonReader faces = json.require("faces", kFaces);
        if (!object.vertices.empty()) read_triangles(faces, known, object);
    });
    read_single_material(json, materials, object);
    return object;
}

// `, did you mean "glass" for "Glass"?`, for the first few names that are similar to a known one or
// mean one.
std::string nearest_materials(const std::vector<std::string>& unmapped,
                              const std::vector<std::string>& known) {
    constexpr std::size_t kMax = 10;  // names that one reads in a message
    std::string list;
    for (std::size_t i = 0; i < std::min(unmapped.size(), kMax); ++i) {
        const std::string near = nearest_name(unmapped[i], known);
        const MaterialGuess guess = guess_material(unmapped[i]);
        if (near.empty() && guess.word.empty()) continue;
        list += (list.empty() ? "" : ", ") + quoted(near.empty() ? guess.material : near) +
                " for " + quoted(unmapped[i]);
    }
    return list.empty() ? "" : ", did you mean " + list + "?";
}

// The scene's material for each of the mesh's: mapped by "materials", else of the same name, else
// "default_material".
std::vector<std::uint32_t> map_materials(const JsonReader& json, const ImportedMesh& mesh,
                                         MaterialTable& materials,
                                         std::vector<std::string>& warnings) {
    std::vector<std::optional<std::uint32_t>> mapped(mesh.material_names.size());
    std::vector<bool> used(mesh.material_names.size(), false);
    for (const std::uint32_t material : mesh.triangle_materials) used[material] = true;
    std::unordered_map<std::string, std::size_t> indices;
    for (const std::string& name : mesh.material_names) indices.emplace(name, indices.size());

    if (const auto mapping = json.find("materials")) {
        for (const auto& [name, target] : mapping->members("an object of material names")) {
            const auto known = indices.find(name);
            std::uint32_t material = 0;
            target.attempt([&, &to = target] { material = materials.require(to); });
            if (known != indices.end()) {
                mapped[known->second] = material;
            } else {
                warnings.push_back(target.message("the mesh has no material " + quoted(name) +
                                                  did_you_mean(name, mesh.material_names) +
                                                  "; it has " + quoted_list(mesh.material_names)));
            }
        }
    }
    std::optional<std::uint32_t> fallback;
    json.read("default_material", [&](const JsonReader& name) {
        fallback = 0;
        fallback = materials.require(name);
    });

    std::vector<std::string> unmapped;
    std::vector<std::uint32_t> result(mapped.size(), 0);
    for (std::size_t i = 0; i < mapped.size(); ++i) {
        if (!used[i]) continue;
        const std::string& name = mesh.material_names[i];
        if (!mapped[i]) mapped[i] = materials.find(name);
        if (!mapped[i]) mapped[i] = fallback;
        if (!mapped[i]) unmapped.push_back(name);
        result[i] = mapped[i].value_or(0);
    }
    if (!unmapped.empty()) {
        json.fail("the mesh's materials " + quoted_list(unmapped) + " are not known" +
                  nearest_materials(unmapped, materials.names()) +
                  "; expected each in \"materials\" or a \"default_material\", both beside "
                  "\"file\", or a material of the same name");
    }
    return result;
}

Object read_mesh(const JsonReader& json, const std::filesystem::path& folder,
                 MaterialTable& materials, std::vector<std::string>& warnings) {
    json.allow_keys(with_common_keys({"file", "materials", "default_material"}));
    constexpr const char* kExpected = "a mesh file, relative to the scene file";
    const JsonReader name_json = json.require("file", kExpected);
    const std::string name = name_json.string(kExpected);
    const std::filesystem::path file = folder / utf8_path(name);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) {
        name_json.fail("no such file, " + quoted(file.string()) + "; expected " + kExpected);
    }
    ImportedMesh mesh;
    try {
        mesh = import_mesh(file);
    } catch (const InputError& reason) {
        name_json.fail("cannot use the mesh " + quoted(file.string()) + ": " + reason.what());
    }
    Object object;
    object.vertices = std::move(mesh.vertices);
    object.triangles = std::move(mesh.triangles);
    object.files = std::move(mesh.files);
    if (const auto single = json.find("material")) {
        for (const char* key : {"materials", "default_material"}) {
            if (const auto other = json.find(key)) {
                other->fail(
                    "cannot be combined with \"material\", which is for the whole mesh; expected "
                    "one of the two");
            }
        }
        set_single_material(object, materials.require(*single));
        return object;
    }
    const auto mapped = map_materials(json, mesh, materials, warnings);
    for (const std::uint32_t material : mesh.triangle_materials) {
        object.triangle_materials.push_back(mapped[material]);
    }
    return object;
}

// Assigns the materials in "surfaces" to triangles of an object.
void read_surfaces(const JsonReader& json, MaterialTable& materials, Object& object) {
    constexpr const char* kSurfaces = "a list of surfaces, each a material and its triangles";
    constexpr const char* kRanges = "a list of ranges [first, last] of triangles";
    const int last_triangle = static_cast<int>(object.triangles.size()) - 1;
    for (const JsonReader& surface : json.items(kSurfaces)) {
        surface.allow_keys({"material", "triangles"});
        std::uint32_t material = 0;
        surface.attempt(
            [&] { material = materials.require(surface.require("material", kMaterialName)); });
        surface.attempt([&] {
            for (const JsonReader& range : surface.require("triangles", kRanges).items(kRanges)) {
                const std::vector<JsonReader> ends = range.items("a range [first, last]");
                if (ends.size() != 2) range.fail("not a range; expected [first, last]");
                const int first = ends[0].integer(0, last_triangle);
                const int last = ends[1].integer(first, last_triangle);
                std::fill(object.triangle_materials.begin() + first,
                          object.triangle_materials.begin() + last + 1, material);
            }
        });
    }
}

bool has_y_up(const JsonReader& json) {
    constexpr const char* kExpected = "\"y\" or \"z\"";
    if (const auto up = json.find("up")) {
        const std::string axis = up->string(kExpected);
        if (axis != "y" && axis != "z") {
            up->fail("unknown axis " + quoted(axis) + "; expected " + kExpected);
        }
        return axis == "y";
    }
    const auto file = json.find("file");
    return file && is_gltf_file(file->string("a file"));
}

// Applies the up axis, then the scale.
void to_local_frame(const JsonReader& json, Object& object) {
    const bool y_up = has_y_up(json);
    constexpr NumberRange kScale{0, 1e6, false, "a number above 0, at most 1e6"};
    const auto scale_json = json.find("scale");
    const float scale = scale_json ? scale_json->real(kScale) : 1;
    const auto too_large = [](float x) {
        return !(std::abs(x) <= static_cast<float>(kLargestCoordinate_m));
    };
    for (Vec3& v : object.vertices) {
        if (y_up) v = {v.x, -v.z, v.y};
        v *= scale;
        if (too_large(v.x) || too_large(v.y) || too_large(v.z)) {
            json.fail("a vertex is more than 1e6 m from the origin; expected a smaller scale");
        }
    }
}

}  // namespace

MaterialTable::MaterialTable(const std::optional<JsonReader>& own) : library_(material_library()) {
    if (!own) return;
    own->attempt([&] {
        for (const auto& member : own->members("an object of materials")) {
            // A material with errors is registered by name, so that its uses are not reported as
            // errors, too.
            Material material;
            member.second.attempt([&] {
                material = read_material(member.first, member.second,
                                         [&](const JsonReader& like) { return known(like); });
            });
            material.name = member.first;
            add(std::move(material));
        }
    });
}

Material MaterialTable::known(const JsonReader& like) const {
    const std::string name = like.string(kMaterialName);
    if (const auto own = indices_.find(name); own != indices_.end()) return materials_[own->second];
    for (const LibraryMaterial& shipped : library_)
        if (shipped.material.name == name) return shipped.material;
    like.fail("unknown material " + quoted(name) + meant(name) +
              "; expected a material of the scene before this one, or one that \"aula materials\" "
              "lists");
}

std::uint32_t MaterialTable::add(Material material) {
    const auto index = static_cast<std::uint32_t>(materials_.size());
    indices_.emplace(material.name, index);
    materials_.push_back(std::move(material));
    return index;
}

std::optional<std::uint32_t> MaterialTable::find(const std::string& name) {
    if (const auto own = indices_.find(name); own != indices_.end()) return own->second;
    const auto shipped = std::find_if(library_.begin(), library_.end(),
                                      [&](const auto& m) { return m.material.name == name; });
    if (shipped == library_.end()) return std::nullopt;
    return add(shipped->material);
}

std::vector<std::string> MaterialTable::names() const {
    std::vector<std::string> names;
    for (const Material& material : materials_) names.push_back(material.name);
    for (const LibraryMaterial& entry : library_) {
        if (!indices_.contains(entry.material.name)) names.push_back(entry.material.name);
    }
    return names;
}

std::string MaterialTable::meant(const std::string& name) const {
    std::string near = did_you_mean(name, names());
    const MaterialGuess guess = guess_material(name);
    if (!near.empty() || guess.word.empty()) return near;
    return ", did you mean " + quoted(guess.material) + "?";
}

std::uint32_t MaterialTable::require(const JsonReader& json) {
    const std::string name = json.string(kMaterialName);
    if (const auto index = find(name)) return *index;
    json.fail("unknown material " + quoted(name) + meant(name) +
              "; expected a material of the scene, or one that \"aula materials\" lists");
}

Object read_object(const JsonReader& json, const std::filesystem::path& folder,
                   MaterialTable& materials, std::vector<std::string>& warnings) {
    const bool mesh = json.find("file").has_value();
    const bool box = json.find("box").has_value();
    const bool faces = json.find("vertices").has_value() || json.find("faces").has_value();
    if (!mesh && !box && !faces &&
        !json.allow_keys(with_common_keys({"file", "box", "vertices", "faces"}))) {
        return {};
    }
    if (int{mesh} + int{box} + int{faces} != 1) {
        json.fail(
            "not one piece of geometry; expected one of \"file\", \"box\", or \"vertices\" "
            "with \"faces\"");
    }
    Object object;
    json.attempt([&] {
        object = mesh  ? read_mesh(json, folder, materials, warnings)
                 : box ? read_box(json, materials)
                       : read_faces(json, materials);
        json.read("surfaces", [&](const JsonReader& x) { read_surfaces(x, materials, object); });
    });
    json.attempt([&] { to_local_frame(json, object); });
    json.read("name", [&](const JsonReader& x) { object.name = x.string("a name"); });
    json.read("translate", [&](const JsonReader& x) { object.translation = read_point(x); });
    json.attempt([&] { object.path = find_trajectory(json); });
    return object;
}

}  // namespace aula
