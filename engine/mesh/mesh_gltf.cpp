#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "aula/exception.h"
#include "engine/input/json_reader.h"
#include "engine/input/names.h"
#include "engine/input/scalar_bytes.h"
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

std::optional<std::string> decode_base64(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3);
    std::uint32_t bits = 0;
    int count = 0;
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    for (const char c : text) {
        const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                          : c >= 'a' && c <= 'z' ? c - 'a' + 26
                          : c >= '0' && c <= '9' ? c - '0' + 52
                          : c == '+'             ? 62
                          : c == '/'             ? 63
                                                 : -1;
        if (digit < 0) return std::nullopt;
        bits = bits << 6U | static_cast<std::uint32_t>(digit);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 0xffU);
    }
    return bytes;
}

std::string decode_percent(const std::string& uri) {
    const auto digit = [](char c) {
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
    };
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const bool escape =
            uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0;
        text += escape ? static_cast<char>(16 * digit(uri[i + 1]) + digit(uri[i + 2])) : uri[i];
        if (escape) i += 2;
    }
    return text;
}

enum class Component : std::uint16_t {
    int8 = 5120,
    uint8 = 5121,
    int16 = 5122,
    uint16 = 5123,
    uint32 = 5125,
    float32 = 5126
};

std::size_t size_of(Component type) {
    if (type == Component::int8 || type == Component::uint8) return 1;
    return type == Component::int16 || type == Component::uint16 ? 2 : 4;
}

std::uint32_t unsigned_at(const char* bytes, Component type) {
    switch (size_of(type)) {
        case 1:
            return read_scalar<std::uint8_t>(bytes, std::endian::little);
        case 2:
            return read_scalar<std::uint16_t>(bytes, std::endian::little);
        default:
            return read_scalar<std::uint32_t>(bytes, std::endian::little);
    }
}

double number_at(const char* bytes, Component type) {
    switch (type) {
        case Component::int8:
            return read_scalar<std::int8_t>(bytes, std::endian::little);
        case Component::int16:
            return read_scalar<std::int16_t>(bytes, std::endian::little);
        case Component::float32:
            return read_scalar<float>(bytes, std::endian::little);
        default:
            return unsigned_at(bytes, type);
    }
}

// Divisor of a normalized integer.
double full_scale(Component type) {
    switch (type) {
        case Component::int8:
            return 127;
        case Component::uint8:
            return 255;
        case Component::int16:
            return 32767;
        case Component::uint16:
            return 65535;
        default:
            return 1;
    }
}

// A strided sequence of elements in a buffer.
struct Elements {
    std::string_view bytes;
    std::size_t stride = 0;

    const char* at(std::size_t index) const { return bytes.data() + index * stride; }
};

// An accessor whose elements are all within its buffer.
struct Accessor {
    std::size_t count = 0;
    Component type = Component::float32;
    bool normalized = false;
    std::optional<Elements> base;  // none: zeros
    // Elements that replace elements of the base, in ascending order of their indices.
    std::size_t sparse_count = 0;
    Component sparse_type = Component::uint32;
    Elements sparse_indices;
    Elements sparse_values;

    // The bytes of an element; null: zeros.
    const char* at(std::size_t index) const {
        std::size_t low = 0;
        std::size_t high = sparse_count;
        while (low < high) {
            const std::size_t middle = low + (high - low) / 2;
            const std::uint32_t found = unsigned_at(sparse_indices.at(middle), sparse_type);
            if (found == index) return sparse_values.at(middle);
            (found < index ? low : high) = found < index ? middle + 1 : middle;
        }
        return base ? base->at(index) : nullptr;
    }

    std::uint32_t index(std::size_t i) const {
        const char* bytes = at(i);
        return bytes == nullptr ? 0 : unsigned_at(bytes, type);
    }

    glm::dvec3 position(std::size_t i) const {
        const char* bytes = at(i);
        if (bytes == nullptr) return glm::dvec3(0);
        glm::dvec3 point;
        for (int axis = 0; axis < 3; ++axis) {
            const double x =
                number_at(bytes + static_cast<std::size_t>(axis) * size_of(type), type);
            point[axis] = normalized ? std::max(-1.0, x / full_scale(type)) : x;
        }
        return point;
    }
};

std::vector<JsonReader> list(const JsonReader& json, const char* key) {
    const auto found = json.find(key);
    return found ? found->items("a list") : std::vector<JsonReader>{};
}

std::size_t size_value(const JsonReader& json, const char* key, std::size_t absent) {
    const auto found = json.find(key);
    return found ? found->unsigned_integer() : absent;
}

// An index into a list of `count` elements.
std::size_t index_value(const JsonReader& json, std::size_t count, const char* of) {
    const std::uint64_t index = json.unsigned_integer();
    if (index >= count) {
        json.fail(std::to_string(index) + " of " + std::to_string(count) + " " + of +
                  "; expected one that exists");
    }
    return index;
}

void refuse_extension(const JsonReader& json, const char* name, const char* what) {
    const auto extensions = json.find("extensions");
    if (extensions && extensions->find(name)) {
        extensions->fail(std::string(name) + " is not read; expected " + what);
    }
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

class GltfReader {
 public:
    GltfReader(const JsonReader& root, std::optional<std::string_view> binary,
               const OpenBuffer& open)
        : root_(root),
          binary_(binary),
          open_(open),
          buffers_(list(root, "buffers")),
          views_(list(root, "bufferViews")),
          accessors_(list(root, "accessors")),
          meshes_(list(root, "meshes")),
          nodes_(list(root, "nodes")),
          materials_(list(root, "materials")),
          buffer_bytes_(buffers_.size()) {}

    ImportedMesh read() {
        const JsonReader version =
            root_.require("asset", "an object with the version").require("version", "\"2.0\"");
        if (version.string("a version").substr(0, 2) != "2.") {
            version.fail("another version of glTF; expected 2.0");
        }
        struct Open {
            JsonReader reference;
            glm::dmat4 parent;
        };
        std::vector<Open> open;
        const auto open_all = [&](const std::vector<JsonReader>& nodes, const glm::dmat4& parent) {
            for (auto n = nodes.rbegin(); n != nodes.rend(); ++n) open.push_back({*n, parent});
        };
        open_all(root_nodes(), glm::dmat4(1));
        std::vector<bool> reached(nodes_.size(), false);
        while (!open.empty()) {
            const Open next = std::move(open.back());
            open.pop_back();
            const std::size_t index = index_value(next.reference, nodes_.size(), "nodes");
            if (reached[index]) next.reference.fail("a node a second time; expected a tree");
            reached[index] = true;
            const JsonReader& node = nodes_[index];
            refuse_extension(node, "EXT_mesh_gpu_instancing", "one node an instance");
            const glm::dmat4 transform = next.parent * local_transform(node);
            if (const auto mesh = node.find("mesh")) {
                add_mesh(meshes_[index_value(*mesh, meshes_.size(), "meshes")], transform);
            }
            open_all(list(node, "children"), transform);
        }
        return builder_.take();
    }

 private:
    std::vector<JsonReader> root_nodes() {
        const std::vector<JsonReader> scenes = list(root_, "scenes");
        const auto chosen = root_.find("scene");
        if (scenes.empty() && !chosen) root_.fail("no scene; expected at least one");
        return list(scenes[chosen ? index_value(*chosen, scenes.size(), "scenes") : 0], "nodes");
    }

    std::string_view buffer(const JsonReader& reference) {
        const std::size_t index = index_value(reference, buffers_.size(), "buffers");
        auto& bytes = buffer_bytes_[index];
        if (bytes) return *bytes;
        const JsonReader& json = buffers_[index];
        const auto uri = json.find("uri");
        if (!uri && (index > 0 || !binary_)) json.fail("a buffer without data; expected \"uri\"");
        bytes = uri ? load(*uri) : *binary_;
        const std::size_t length = size_value(json, "byteLength", 0);
        if (length > bytes->size()) {
            json.fail("a buffer of " + std::to_string(bytes->size()) + " bytes; expected " +
                      std::to_string(length));
        }
        return *bytes = bytes->substr(0, length);
    }

    std::string_view load(const JsonReader& uri) {
        const std::string text = uri.string("a data URI or a file beside this one");
        if (text.starts_with("data:")) {
            constexpr std::string_view kMark = ";base64,";
            const std::size_t mark = text.find(kMark);
            auto bytes = mark == std::string::npos
                             ? std::nullopt
                             : decode_base64(std::string_view(text).substr(mark + kMark.size()));
            if (!bytes) uri.fail("a data URI that is not in base64; expected base64");
            return keep(uri, *std::move(bytes));
        }
        const std::filesystem::path file = decode_percent(text);
        if (file.is_absolute() || std::find(file.begin(), file.end(), "..") != file.end()) {
            uri.fail(quoted(file.string()) + " is elsewhere; expected a file beside the glTF file");
        }
        try {
            return keep(uri, open_(file));
        } catch (const InputError& reason) {
            uri.fail("the buffer " + quoted(file.string()) + ": " + reason.what());
        }
    }

    std::string_view keep(const JsonReader& uri, std::string bytes) {
        loaded_bytes_ += bytes.size();
        if (loaded_bytes_ > kMaxMeshBytes) {
            uri.fail("buffers of " + std::to_string(loaded_bytes_) + " bytes; expected at most " +
                     std::to_string(kMaxMeshBytes));
        }
        return owned_.emplace_back(std::move(bytes));
    }

    // `count` elements of `size` bytes in the view that "bufferView" of `json` names.
    Elements elements(const JsonReader& json, std::size_t count, std::size_t size) {
        const JsonReader reference = json.require("bufferView", "the number of a buffer view");
        const JsonReader& view = views_[index_value(reference, views_.size(), "buffer views")];
        refuse_extension(view, "EXT_meshopt_compression", "data without compression");
        std::string_view bytes = buffer(view.require("buffer", "the number of a buffer"));
        const std::size_t begin = size_value(view, "byteOffset", 0);
        const std::size_t length = size_value(view, "byteLength", 0);
        if (begin > bytes.size() || length > bytes.size() - begin) {
            view.fail("bytes beyond the buffer's " + std::to_string(bytes.size()) +
                      "; expected a part of it");
        }
        bytes = bytes.substr(begin, length);
        const std::size_t stride = size_value(view, "byteStride", size);
        if (stride < size) {
            view.fail("a stride of " + std::to_string(stride) + "; expected at least " +
                      std::to_string(size));
        }
        const std::size_t offset = size_value(json, "byteOffset", 0);
        const bool fits = offset <= bytes.size() && size <= bytes.size() - offset &&
                          count - 1 <= (bytes.size() - offset - size) / stride;
        if (!fits) {
            json.fail(std::to_string(count) + " elements beyond the buffer view's " +
                      std::to_string(bytes.size()) + " bytes; expected a part of it");
        }
        return {bytes.substr(offset), stride};
    }

    static Component component(const JsonReader& json, std::initializer_list<Component> allowed,
                               const char* expected) {
        const JsonReader type = json.require("componentType", "the type of the components");
        const auto number = type.unsigned_integer();
        for (const Component c : allowed) {
            if (number == static_cast<std::uint64_t>(c)) return c;
        }
        type.fail("the type " + std::to_string(number) + "; expected " + expected);
    }

    Accessor accessor(const JsonReader& reference, std::size_t components,
                      std::initializer_list<Component> allowed, const char* expected) {
        const JsonReader& json = accessors_[index_value(reference, accessors_.size(), "accessors")];
        const JsonReader type = json.require("type", "the type of the elements");
        const char* const expected_type = components == 3 ? "VEC3" : "SCALAR";
        if (type.string("a type") != expected_type) {
            type.fail("elements of another type; expected " + std::string(expected_type));
        }
        Accessor result;
        result.type = component(json, allowed, expected);
        result.count = json.require("count", "the number of elements").unsigned_integer();
        if (result.count == 0) json.fail("no elements; expected at least one");
        if (const auto x = json.find("normalized")) result.normalized = x->boolean();
        const std::size_t size = components * size_of(result.type);
        const auto sparse = json.find("sparse");
        if (json.find("bufferView") || !sparse) result.base = elements(json, result.count, size);
        if (sparse) {
            result.sparse_count = size_value(*sparse, "count", 0);
            if (result.sparse_count == 0) sparse->fail("no elements; expected at least one");
            const JsonReader indices = sparse->require("indices", "an object");
            result.sparse_type =
                component(indices, {Component::uint8, Component::uint16, Component::uint32},
                          "5121, 5123 or 5125");
            result.sparse_indices =
                elements(indices, result.sparse_count, size_of(result.sparse_type));
            result.sparse_values =
                elements(sparse->require("values", "an object"), result.sparse_count, size);
        }
        return result;
    }

    std::uint32_t material(const JsonReader& primitive) {
        const auto reference = primitive.find("material");
        if (!reference) return builder_.material(kNamelessMaterial);
        const std::size_t index = index_value(*reference, materials_.size(), "materials");
        const auto name = materials_[index].find("name");
        return builder_.material(name ? name->string("a name") : kNamelessMaterial);
    }

    void add_mesh(const JsonReader& mesh, const glm::dmat4& transform) {
        for (const JsonReader& primitive : list(mesh, "primitives")) {
            if (++primitive_count_ > kMaxPrimitives) {
                primitive.fail("more than " + std::to_string(kMaxPrimitives) +
                               " primitives in all nodes; expected fewer");
            }
            add_primitive(primitive, transform);
        }
    }

    void add_primitive(const JsonReader& primitive, const glm::dmat4& transform) {
        enum Mode { triangles = 4, triangle_strip = 5, triangle_fan = 6 };
        const auto mode_json = primitive.find("mode");
        const int mode = mode_json ? mode_json->integer(0, 6) : triangles;
        if (mode < triangles) return;  // points and lines
        refuse_extension(primitive, "KHR_draco_mesh_compression", "data without compression");
        const Accessor positions =
            accessor(primitive.require("attributes", "an object with \"POSITION\"")
                         .require("POSITION", "the number of an accessor"),
                     3,
                     {Component::float32, Component::int8, Component::uint8, Component::int16,
                      Component::uint16},
                     "5126, or 5120 to 5123");
        if (positions.count > 3 * kMaxMeshTriangles) {
            primitive.fail(std::to_string(positions.count) + " vertices; expected at most " +
                           std::to_string(3 * kMaxMeshTriangles));
        }
        std::optional<Accessor> indices;
        if (const auto reference = primitive.find("indices")) {
            indices =
                accessor(*reference, 1, {Component::uint8, Component::uint16, Component::uint32},
                         "5121, 5123 or 5125");
        }
        const std::size_t count = indices ? indices->count : positions.count;
        if (mode == triangles ? count % 3 != 0 : count < 3) {
            primitive.fail(std::to_string(count) + " corners; expected " +
                           (mode == triangles ? "a multiple of 3" : "at least 3"));
        }
        const std::uint32_t name = material(primitive);
        used_.clear();
        const auto corner = [&](std::size_t i) {
            const std::size_t index = indices ? indices->index(i) : i;
            if (index >= positions.count) {
                primitive.fail("vertex " + std::to_string(index) + " of " +
                               std::to_string(positions.count) + "; expected vertices that exist");
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
    std::uint32_t vertex(const Accessor& positions, std::size_t index,
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

    static constexpr std::uint64_t kMaxPrimitives = 1'000'000;
    static constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

    const JsonReader& root_;
    std::optional<std::string_view> binary_;
    const OpenBuffer& open_;
    std::vector<JsonReader> buffers_, views_, accessors_, meshes_, nodes_, materials_;
    std::vector<std::optional<std::string_view>> buffer_bytes_;
    std::deque<std::string> owned_;
    std::uint64_t loaded_bytes_ = 0;
    std::uint64_t primitive_count_ = 0;
    MeshBuilder builder_;
    std::vector<std::uint32_t> new_indices_;  // the builder's indices, [vertex of the primitive]
    std::vector<std::size_t> used_;           // elements of new_indices_ that are set
};

}  // namespace

ImportedMesh read_gltf(std::string_view bytes, const OpenBuffer& open) {
    Chunks chunks = find_chunks(bytes);
    // Some programs pad the JSON chunk of a GLB file with NUL instead of spaces.
    while (chunks.binary && chunks.json.ends_with('\0')) chunks.json.remove_suffix(1);
    const JsonValue json = parse_json(std::string(chunks.json), kPlace);
    const JsonReader root(json, kPlace);
    return GltfReader(root, chunks.binary, open).read();
}

}  // namespace aula
