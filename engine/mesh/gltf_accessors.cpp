#include "engine/mesh/gltf_accessors.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "aula/exception.h"
#include "engine/input/names.h"
#include "engine/input/scalar_bytes.h"
#include "engine/mesh/gltf_json.h"
#include "engine/mesh/mesh_import.h"
#include "process/files.h"

namespace aula {

namespace {

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

std::size_t size_value(const JsonReader& json, const char* key, std::size_t absent) {
    const auto found = json.find(key);
    return found ? found->unsigned_integer() : absent;
}

}  // namespace

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

std::size_t GltfAccessor::size_of(Component type) {
    if (type == Component::int8 || type == Component::uint8) return 1;
    return type == Component::int16 || type == Component::uint16 ? 2 : 4;
}

std::uint32_t GltfAccessor::unsigned_at(const char* bytes, Component type) {
    switch (size_of(type)) {
        case 1:
            return read_scalar<std::uint8_t>(bytes, std::endian::little);
        case 2:
            return read_scalar<std::uint16_t>(bytes, std::endian::little);
        default:
            return read_scalar<std::uint32_t>(bytes, std::endian::little);
    }
}

double GltfAccessor::number_at(const char* bytes, Component type) {
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

/// Divisor of a normalized integer.
double GltfAccessor::full_scale(Component type) {
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

/// The bytes of an element; null: zeros.
const char* GltfAccessor::at(std::size_t index) const {
    std::size_t low = 0;
    std::size_t high = sparse_count_;
    while (low < high) {
        const std::size_t middle = low + (high - low) / 2;
        const std::uint32_t found = unsigned_at(sparse_indices_.at(middle), sparse_type_);
        if (found == index) return sparse_values_.at(middle);
        (found < index ? low : high) = found < index ? middle + 1 : middle;
    }
    return base_ ? base_->at(index) : nullptr;
}

std::uint32_t GltfAccessor::index(std::size_t i) const {
    const char* bytes = at(i);
    return bytes == nullptr ? 0 : unsigned_at(bytes, type_);
}

glm::dvec3 GltfAccessor::position(std::size_t i) const {
    const char* bytes = at(i);
    if (bytes == nullptr) return glm::dvec3(0);
    return {component_at(bytes, 0), component_at(bytes, 1), component_at(bytes, 2)};
}

glm::dquat GltfAccessor::rotation(std::size_t i) const {
    const char* bytes = at(i);
    if (bytes == nullptr) return glm::dquat(1, 0, 0, 0);
    // In the order w, x, y, z.
    return glm::normalize(glm::dquat(component_at(bytes, 3), component_at(bytes, 0),
                                     component_at(bytes, 1), component_at(bytes, 2)));
}

double GltfAccessor::component_at(const char* bytes, int component) const {
    const double x = number_at(bytes + static_cast<std::size_t>(component) * size_of(type_), type_);
    return normalized_ ? std::max(-1.0, x / full_scale(type_)) : x;
}

GltfAccessors::GltfAccessors(const JsonReader& root, std::optional<std::string_view> binary,
                             const OpenBuffer& open)
    : binary_(binary),
      open_(open),
      buffers_(gltf_list(root, "buffers")),
      views_(gltf_list(root, "bufferViews")),
      accessors_(gltf_list(root, "accessors")),
      buffer_bytes_(buffers_.size()) {
    for (std::size_t i = 0; i < kCompressions.size(); ++i)
        is_required_[i] = requires_gltf_extension(root, kCompressions[i]);
}

GltfAccessor GltfAccessors::positions(const JsonReader& reference) {
    return accessor(reference, 3,
                    {Component::float32, Component::int8, Component::uint8, Component::int16,
                     Component::uint16},
                    "5126, or 5120 to 5123");
}

GltfAccessor GltfAccessors::rotations(const JsonReader& reference) {
    return accessor(reference, 4, {Component::float32, Component::int8, Component::int16},
                    "5126, 5120 or 5122");
}

GltfAccessor GltfAccessors::indices(const JsonReader& reference) {
    return accessor(reference, 1, {Component::uint8, Component::uint16, Component::uint32},
                    "5121, 5123 or 5125");
}

/// True if the buffer whose number is `reference` has bytes in this file or a URI.
bool GltfAccessors::has_data(const JsonReader& reference) const {
    const std::size_t index = gltf_index(reference, buffers_.size(), "buffers");
    return (index == 0 && binary_) || buffers_[index].find("uri");
}

bool GltfAccessors::is_stored(const JsonReader& reference) const {
    return accessors_[gltf_index(reference, accessors_.size(), "accessors")]
        .find("bufferView")
        .has_value();
}

std::string_view GltfAccessors::buffer(const JsonReader& reference) {
    const std::size_t index = gltf_index(reference, buffers_.size(), "buffers");
    auto& bytes = buffer_bytes_[index];
    if (bytes) return *bytes;
    const JsonReader& json = buffers_[index];
    const auto uri = json.find("uri");
    if (!has_data(reference)) json.fail("a buffer without data; expected \"uri\"");
    bytes = uri ? load(*uri) : *binary_;
    const std::size_t length = size_value(json, "byteLength", 0);
    if (length > bytes->size()) {
        json.fail("a buffer of " + std::to_string(bytes->size()) + " bytes; expected " +
                  std::to_string(length));
    }
    return *bytes = bytes->substr(0, length);
}

std::string_view GltfAccessors::load(const JsonReader& uri) {
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
    const std::filesystem::path file = utf8_path(decode_percent(text));
    if (file.is_absolute() || std::find(file.begin(), file.end(), "..") != file.end()) {
        uri.fail(quoted(file.string()) + " is elsewhere; expected a file beside the glTF file");
    }
    try {
        return keep(uri, open_(file));
    } catch (const InputError& reason) {
        uri.fail("the buffer " + quoted(file.string()) + ": " + reason.what());
    }
}

std::string_view GltfAccessors::keep(const JsonReader& uri, std::string bytes) {
    loaded_bytes_ += bytes.size();
    if (loaded_bytes_ > kMaxMeshBytes) {
        uri.fail("buffers of " + std::to_string(loaded_bytes_) + " bytes; expected at most " +
                 std::to_string(kMaxMeshBytes));
    }
    return owned_.emplace_back(std::move(bytes));
}

std::string_view GltfAccessors::view(const JsonReader& reference) {
    const JsonReader& view = views_[gltf_index(reference, views_.size(), "buffer views")];
    const JsonReader of_view = view.require("buffer", "the number of a buffer");
    // A reader without the extension uses the data of the fallback buffer, which is empty where the
    // extension is required.
    for (std::size_t i = 0; i < kCompressions.size(); ++i) {
        if (!has_data(of_view) || is_required_[i])
            refuse_gltf_extension(view, kCompressions[i], kUncompressed);
    }
    const std::string_view bytes = buffer(of_view);
    const std::size_t begin = size_value(view, "byteOffset", 0);
    const std::size_t length = size_value(view, "byteLength", 0);
    if (begin > bytes.size() || length > bytes.size() - begin) {
        view.fail("bytes beyond the buffer's " + std::to_string(bytes.size()) +
                  "; expected a part of it");
    }
    return bytes.substr(begin, length);
}

/// `count` elements of `size` bytes in the view that "bufferView" of `json` names.
GltfAccessors::Elements GltfAccessors::elements(const JsonReader& json, std::size_t count,
                                                std::size_t size) {
    const JsonReader reference = json.require("bufferView", "the number of a buffer view");
    const std::string_view bytes = this->view(reference);
    const JsonReader& view = views_[gltf_index(reference, views_.size(), "buffer views")];
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

GltfAccessors::Component GltfAccessors::component(const JsonReader& json,
                                                  std::initializer_list<Component> allowed,
                                                  const char* expected) {
    const JsonReader type = json.require("componentType", "the type of the components");
    const auto number = type.unsigned_integer();
    for (const Component c : allowed) {
        if (number == static_cast<std::uint64_t>(c)) return c;
    }
    type.fail("the type " + std::to_string(number) + "; expected " + expected);
}

GltfAccessor GltfAccessors::accessor(const JsonReader& reference, std::size_t components,
                                     std::initializer_list<Component> allowed,
                                     const char* expected) {
    const JsonReader& json = accessors_[gltf_index(reference, accessors_.size(), "accessors")];
    const JsonReader type = json.require("type", "the type of the elements");
    const char* const expected_type = components == 4   ? "VEC4"
                                      : components == 3 ? "VEC3"
                                                        : "SCALAR";
    if (type.string("a type") != expected_type) {
        type.fail("elements of another type; expected " + std::string(expected_type));
    }
    GltfAccessor result;
    result.type_ = component(json, allowed, expected);
    result.count_ = json.require("count", "the number of elements").unsigned_integer();
    if (result.count_ == 0) json.fail("no elements; expected at least one");
    if (const auto x = json.find("normalized")) result.normalized_ = x->boolean();
    const std::size_t size = components * GltfAccessor::size_of(result.type_);
    const auto sparse = json.find("sparse");
    if (json.find("bufferView") || !sparse) result.base_ = elements(json, result.count_, size);
    if (sparse) {
        result.sparse_count_ = size_value(*sparse, "count", 0);
        if (result.sparse_count_ == 0) sparse->fail("no elements; expected at least one");
        const JsonReader indices = sparse->require("indices", "an object");
        result.sparse_type_ =
            component(indices, {Component::uint8, Component::uint16, Component::uint32},
                      "5121, 5123 or 5125");
        result.sparse_indices_ =
            elements(indices, result.sparse_count_, GltfAccessor::size_of(result.sparse_type_));
        result.sparse_values_ =
            elements(sparse->require("values", "an object"), result.sparse_count_, size);
    }
    return result;
}

}  // namespace aula
