#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/input/scalar_bytes.h"
#include "engine/mesh/gltf_accessors.h"
#include "engine/mesh/gltf_json.h"
#include "engine/mesh/gltf_places.h"
#include "engine/mesh/mesh_builder.h"
#include "engine/mesh/mesh_readers.h"

namespace aula {
namespace {

const std::string kPlace = "in its JSON";  // before JSON pointers in messages

struct Chunks {
    std::string_view json;
    std::optional<std::string_view> binary;
};

// The parts of a GLB file, or the whole text of a glTF file.
Chunks find_chunks(std::string_view file) {
    constexpr std::uint32_t kJson = 0x4E4F534A;
    constexpr std::uint32_t kBinary = 0x004E4942;
    const auto word = [&](std::size_t offset) {
        return read_scalar<std::uint32_t>(file.data() + offset, std::endian::little);
    };
    if (file.substr(0, 4) != "glTF") return {file, std::nullopt};
    if (file.size() < 12 || word(4) != 2) {
        throw InputError("a GLB file of another version; expected version 2");
    }
    Chunks chunks;
    bool has_json = false;
    for (std::size_t at = 12; file.size() - at >= 8;) {
        const std::size_t size = word(at);
        const std::uint32_t type = word(at + 4);
        at += 8;
        if (size > file.size() - at)
            throw InputError("a truncated GLB file; expected a complete one");
        const std::string_view chunk = file.substr(at, size);
        if (type == kJson && !has_json) chunks.json = chunk;
        if (type == kBinary && !chunks.binary) chunks.binary = chunk;
        has_json = has_json || type == kJson;
        at += size;
    }
    if (!has_json) throw InputError("a GLB file without JSON; expected a chunk of it");
    return chunks;
}

glm::dmat4 local_transform(const JsonReader& node) {
    constexpr NumberRange kAny;
    const auto numbers = [&](const char* key, std::size_t count) {
        std::vector<double> values;
        if (const auto json = node.find(key)) {
            for (const JsonReader& item : json->items("a list of numbers")) {
                values.push_back(item.number(kAny));
            }
            if (values.size() != count) {
                json->fail("a list of " + std::to_string(values.size()) + "; expected " +
                           std::to_string(count) + " numbers");
            }
        }
        return values;
    };
    if (const auto m = numbers("matrix", 16); !m.empty()) {
        glm::dmat4 matrix;
        for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
        return matrix;
    }
    glm::dmat4 matrix(1);
    if (const auto r = numbers("rotation", 4); !r.empty()) {
        matrix = glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2]));
    }
    if (const auto s = numbers("scale", 3); !s.empty()) {
        for (int axis = 0; axis < 3; ++axis) matrix[axis] *= s[static_cast<std::size_t>(axis)];
    }
    if (const auto t = numbers("translation", 3); !t.empty()) {
        matrix[3] = glm::dvec4(t[0], t[1], t[2], 1);
    }
    return matrix;
}

/// The bytes of an item of "audio" that are inside the file. Valid as long as the accessors.
std::string_view sound_bytes(const JsonReader& sound, GltfAccessors& accessors) {
    const auto uri = sound.find("uri");
    return uri ? accessors.data(*uri)
               : accessors.view(sound.require("bufferView", "the number of a buffer view"));
}

class GltfReader {
 public:
    GltfReader(const JsonReader& root, std::optional<std::string_view> binary,
               const OpenBuffer& open)
        : root_(root),
          accessors_(root, binary, open),
          meshes_(gltf_list(root, "meshes")),
          nodes_(gltf_list(root, "nodes")),
          materials_(gltf_list(root, "materials")),
          places_(root),
          requires_draco_(requires_gltf_extension(root, kDraco)) {}

    ImportedMesh read() {
        const JsonReader version =
            root_.require("asset", "an object with the version").require("version", "\"2.0\"");
        if (version.string("a version").substr(0, 2) != "2.") {
            version.fail("another version of glTF; expected 2.0");
        }
        const std::vector<JsonReader> scenes = gltf_list(root_, "scenes");
        const auto chosen = root_.find("scene");
        if (scenes.empty() && !chosen) root_.fail("no scene; expected at least one");
        const std::size_t scene =
            chosen ? gltf_index(*chosen, scenes.size(), "scenes") : first_with_faces(scenes);
        read_nodes(gltf_list(scenes[scene], "nodes"));
        if (chosen && !builder_.has_faces() && scenes.size() > 1)
            chosen->fail("scene " + std::to_string(scene) + " of " + std::to_string(scenes.size()) +
                         " holds no triangle; expected the number of one that does");
        ImportedMesh mesh = builder_.take();
        mesh.places = places_.take();
        mesh.shapes_of_sources = places_.shapes_of_sources();
        mesh.sounds_inside = sounds_of(mesh.places);
        const auto of_scene = scenes[scene].find("name");
        mesh.scene = of_scene ? of_scene->string("a name") : std::to_string(scene);
        mesh.scene_count = scenes.size();
        if (const auto audio = gltf_extension(scenes[scene], kGltfAudio))
            mesh.global_emitter_count = gltf_list(*audio, "emitters").size();
        for (const JsonReader& material : materials_) {
            const auto name = material.find("name");
            const auto extras = material.find("extras");
            if (name && extras && extras->is_object())
                mesh.material_extras.emplace_back(name->string("a name"), extras->value());
        }
        return mesh;
    }

 private:
    /// The first scene that has triangles, strips or fans; 0 if none has. Scenes may share nodes,
    /// and nodes meshes: each is searched once.
    std::size_t first_with_faces(const std::vector<JsonReader>& scenes) const {
        std::vector<bool> searched(meshes_.size(), false);
        std::vector<bool> reached(nodes_.size(), false);
        for (std::size_t scene = 0; scene < scenes.size(); ++scene) {
            std::vector<JsonReader> open = gltf_list(scenes[scene], "nodes");
            while (!open.empty()) {
                const std::size_t index = gltf_index(open.back(), nodes_.size(), "nodes");
                open.pop_back();
                if (reached[index]) continue;
                reached[index] = true;
                const std::vector<JsonReader> children = gltf_list(nodes_[index], "children");
                open.insert(open.end(), children.begin(), children.end());
                const auto reference = nodes_[index].find("mesh");
                if (!reference) continue;
                const std::size_t mesh = gltf_index(*reference, meshes_.size(), "meshes");
                if (searched[mesh]) continue;
                searched[mesh] = true;
                for (const JsonReader& primitive : gltf_list(meshes_[mesh], "primitives"))
                    if (mode_of(primitive) >= triangles) return scene;
            }
        }
        return 0;
    }

    enum Mode { triangles = 4, triangle_strip = 5, triangle_fan = 6 };

    /// The beginnings of the sounds inside that places have.
    std::map<std::size_t, SoundBeginning> sounds_of(const std::vector<ImportedPlace>& places) {
        std::map<std::size_t, SoundBeginning> sounds;
        const auto audio = gltf_extension(root_, kGltfAudio);
        if (!audio) return sounds;
        const std::vector<JsonReader> all = gltf_list(*audio, "audio");
        for (const ImportedPlace& place : places) {
            if (!place.sound_inside) continue;
            const auto [sound, is_new] = sounds.try_emplace(*place.sound_inside);
            if (!is_new) continue;
            try {
                const std::string_view bytes = sound_bytes(all[sound->first], accessors_);
                sound->second.bytes = bytes.substr(0, SoundBeginning::kBytes);
            } catch (const InputError& reason) {
                sound->second.error = reason.what();
            }
        }
        return sounds;
    }

    static int mode_of(const JsonReader& primitive) {
        const auto mode = primitive.find("mode");
        return mode ? mode->integer(0, 6) : triangles;
    }

    /// Reads the trees of nodes.
    void read_nodes(const std::vector<JsonReader>& roots) {
        struct Open {
            JsonReader reference;
            glm::dmat4 parent;
        };
        std::vector<Open> open;
        const auto open_all = [&](const std::vector<JsonReader>& nodes, const glm::dmat4& parent) {
            for (auto n = nodes.rbegin(); n != nodes.rend(); ++n) open.push_back({*n, parent});
        };
        open_all(roots, glm::dmat4(1));
        std::vector<bool> reached(nodes_.size(), false);
        while (!open.empty()) {
            const Open next = std::move(open.back());
            open.pop_back();
            const std::size_t index = gltf_index(next.reference, nodes_.size(), "nodes");
            if (reached[index]) next.reference.fail("a node a second time; expected a tree");
            reached[index] = true;
            const JsonReader& node = nodes_[index];
            const glm::dmat4 transform = next.parent * local_transform(node);
            if (const auto mesh = node.find("mesh")) {
                for (const glm::dmat4& instance : instances(node))
                    add_mesh(meshes_[gltf_index(*mesh, meshes_.size(), "meshes")],
                             transform * instance);
            }
            places_.add(node, transform);
            open_all(gltf_list(node, "children"), transform);
        }
    }

    std::uint32_t material(const JsonReader& primitive) {
        const auto reference = primitive.find("material");
        if (!reference) return builder_.material(kNamelessMaterial);
        const std::size_t index = gltf_index(*reference, materials_.size(), "materials");
        const auto name = materials_[index].find("name");
        return builder_.material(name ? name->string("a name") : kNamelessMaterial);
    }

    /// The transforms of EXT_mesh_gpu_instancing, in a node; without it, one that changes nothing.
    std::vector<glm::dmat4> instances(const JsonReader& node) {
        const auto extensions = node.find("extensions");
        const auto instancing =
            extensions ? extensions->find("EXT_mesh_gpu_instancing") : std::nullopt;
        if (!instancing) return {glm::dmat4(1)};
        const JsonReader attributes =
            instancing->require("attributes", "an object with \"TRANSLATION\"");
        std::optional<GltfAccessor> translation, rotation, scale;
        std::optional<std::size_t> count;
        const auto take = [&](const char* name, std::optional<GltfAccessor>& to, bool rotates) {
            const auto reference = attributes.find(name);
            if (!reference) return;
            to = rotates ? accessors_.rotations(*reference) : accessors_.positions(*reference);
            if (count.value_or(to->count()) != to->count() || to->count() > kMaxPrimitives)
                reference->fail(std::to_string(to->count()) + " instances; expected " +
                                (count ? std::to_string(*count) : "fewer"));
            count = to->count();
        };
        take("TRANSLATION", translation, false);
        take("ROTATION", rotation, true);
        take("SCALE", scale, false);
        std::vector<glm::dmat4> transforms(count.value_or(1), glm::dmat4(1));
        for (std::size_t i = 0; i < transforms.size(); ++i) {
            glm::dmat4& transform = transforms[i];
            if (rotation) transform = glm::mat4_cast(rotation->rotation(i));
            for (int axis = 0; scale && axis < 3; ++axis)
                transform[axis] *= scale->position(i)[axis];
            if (translation) transform[3] = glm::dvec4(translation->position(i), 1);
        }
        return transforms;
    }

    void add_mesh(const JsonReader& mesh, const glm::dmat4& transform) {
        for (const JsonReader& primitive : gltf_list(mesh, "primitives")) {
            if (++primitive_count_ > kMaxPrimitives) {
                primitive.fail("more than " + std::to_string(kMaxPrimitives) +
                               " primitives in all nodes; expected fewer");
            }
            add_primitive(primitive, transform);
        }
    }

    void add_primitive(const JsonReader& primitive, const glm::dmat4& transform) {
        const int mode = mode_of(primitive);
        if (mode < triangles) return;  // points and lines
        const JsonReader position = primitive.require("attributes", "an object with \"POSITION\"")
                                        .require("POSITION", "the number of an accessor");
        if (!accessors_.is_stored(position) || requires_draco_)
            refuse_gltf_extension(primitive, kDraco, kUncompressed);
        const GltfAccessor positions = accessors_.positions(position);
        if (positions.count() > 3 * kMaxMeshTriangles) {
            primitive.fail(std::to_string(positions.count()) + " vertices; expected at most " +
                           std::to_string(3 * kMaxMeshTriangles));
        }
        std::optional<GltfAccessor> indices;
        if (const auto reference = primitive.find("indices")) {
            indices = accessors_.indices(*reference);
        }
        const std::size_t count = indices ? indices->count() : positions.count();
        if (mode == triangles ? count % 3 != 0 : count < 3) {
            primitive.fail(std::to_string(count) + " corners; expected " +
                           (mode == triangles ? "a multiple of 3" : "at least 3"));
        }
        const std::uint32_t name = material(primitive);
        used_.clear();
        const auto corner = [&](std::size_t i) {
            const std::size_t index = indices ? indices->index(i) : i;
            if (index >= positions.count()) {
                primitive.fail("vertex " + std::to_string(index) + " of " +
                               std::to_string(positions.count()) +
                               "; expected vertices that exist");
            }
            return vertex(positions, index, transform);
        };
        for (std::size_t i = 0; i + 2 < count; i += mode == triangles ? 3 : 1) {
            const bool odd = mode == triangle_strip && i % 2 == 1;
            builder_.add_face(std::array{corner(mode == triangle_fan ? 0 : i),
                                         corner(odd ? i + 2 : i + 1), corner(odd ? i + 1 : i + 2)},
                              name);
        }
        for (const std::size_t index : used_) new_indices_[index] = kUnused;
    }

    // The builder's index of a position, which is added when the primitive first uses it. Many
    // primitives may share an accessor.
    std::uint32_t vertex(const GltfAccessor& positions, std::size_t index,
                         const glm::dmat4& transform) {
        if (index >= new_indices_.size()) {
            new_indices_.resize(std::max(index + 1, 2 * new_indices_.size()), kUnused);
        }
        std::uint32_t& number = new_indices_[index];
        if (number == kUnused) {
            const glm::dvec4 point = transform * glm::dvec4(positions.position(index), 1);
            number = static_cast<std::uint32_t>(builder_.vertex_count());
            builder_.add_vertex(point.x, point.y, point.z);
            used_.push_back(index);
        }
        return number;
    }

    /// Bounds the time of files whose nodes name each other's meshes many times.
    static constexpr std::uint64_t kMaxPrimitives = 1'000'000;
    static constexpr const char* kDraco = "KHR_draco_mesh_compression";
    static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

    const JsonReader& root_;
    GltfAccessors accessors_;
    std::vector<JsonReader> meshes_, nodes_, materials_;
    GltfPlaces places_;
    bool requires_draco_;
    std::uint64_t primitive_count_ = 0;
    MeshBuilder builder_;
    std::vector<std::uint32_t> new_indices_;  // the builder's indices, [vertex of the primitive]
    std::vector<std::size_t> used_;           // elements of new_indices_ that are set
};

JsonValue parse_chunk(const Chunks& chunks) {
    std::string_view text = chunks.json;
    // Some programs pad the JSON chunk of a GLB file with NUL instead of spaces.
    while (chunks.binary && text.ends_with('\0')) text.remove_suffix(1);
    return parse_json(std::string(text), kPlace);
}

}  // namespace

std::string read_gltf_sound(std::string_view bytes, std::size_t number, const OpenBuffer& open) {
    const Chunks chunks = find_chunks(bytes);
    const JsonValue json = parse_chunk(chunks);
    const JsonReader root(json, kPlace);
    GltfAccessors accessors(root, chunks.binary, open);
    const auto audio = gltf_extension(root, kGltfAudio);
    const std::vector<JsonReader> sounds =
        audio ? gltf_list(*audio, "audio") : std::vector<JsonReader>{};
    if (number >= sounds.size())
        throw InputError("has no sound " + std::to_string(number) + "; expected a number below " +
                         std::to_string(sounds.size()));
    return std::string(sound_bytes(sounds[number], accessors));
}

ImportedMesh read_gltf(std::string_view bytes, const OpenBuffer& open) {
    const Chunks chunks = find_chunks(bytes);
    const JsonValue json = parse_chunk(chunks);
    const JsonReader root(json, kPlace);
    return GltfReader(root, chunks.binary, open).read();
}

}  // namespace aula
