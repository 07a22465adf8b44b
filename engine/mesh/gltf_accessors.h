#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/input/json_reader.h"
#include "engine/mesh/mesh_readers.h"

namespace aula {

/// The text of a URI whose characters may be written as "%20".
std::string decode_percent(const std::string& uri);

/// Typed elements in a buffer of a glTF file, all of them inside the buffer. Valid as long as the
/// GltfAccessors that made it.
class GltfAccessor {
 public:
    std::size_t count() const { return count_; }

    /// Element `i` < count() as an index, as a point, or as a rotation.
    std::uint32_t index(std::size_t i) const;
    glm::dvec3 position(std::size_t i) const;
    glm::dquat rotation(std::size_t i) const;

 private:
    friend class GltfAccessors;

    /// As in the file.
    enum class Component : std::uint16_t {
        int8 = 5120,
        uint8 = 5121,
        int16 = 5122,
        uint16 = 5123,
        uint32 = 5125,
        float32 = 5126
    };

    /// A strided sequence of elements in a buffer.
    struct Elements {
        std::string_view bytes;
        std::size_t stride = 0;

        const char* at(std::size_t index) const { return bytes.data() + index * stride; }
    };

    static std::size_t size_of(Component type);
    static std::uint32_t unsigned_at(const char* bytes, Component type);
    static double number_at(const char* bytes, Component type);
    static double full_scale(Component type);
    const char* at(std::size_t index) const;
    double component_at(const char* bytes, int component) const;

    std::size_t count_ = 0;
    Component type_ = Component::float32;
    bool normalized_ = false;
    std::optional<Elements> base_;  ///< none: zeros
    // Elements that replace elements of the base, in ascending order of their indices.
    std::size_t sparse_count_ = 0;
    Component sparse_type_ = Component::uint32;
    Elements sparse_indices_;
    Elements sparse_values_;
};

/// The accessors, buffer views and buffers of a glTF file. Buffers are loaded when first used: from
/// the binary chunk of a GLB file, a data URI or a file. The file need not be valid; all functions
/// throw InputError with the place of the error.
class GltfAccessors {
 public:
    /// `binary`: the binary chunk of a GLB file. The arguments must outlive this object.
    GltfAccessors(const JsonReader& root, std::optional<std::string_view> binary,
                  const OpenBuffer& open);
    GltfAccessors(const GltfAccessors&) = delete;
    GltfAccessors& operator=(const GltfAccessors&) = delete;

    /// The accessor whose number is `reference`, of points, of rotations or of indices.
    GltfAccessor positions(const JsonReader& reference);
    GltfAccessor rotations(const JsonReader& reference);
    GltfAccessor indices(const JsonReader& reference);

    /// The bytes of the buffer view whose number is `reference`, or of a data URI.
    std::string_view view(const JsonReader& reference);
    std::string_view data(const JsonReader& uri) { return load(uri); }

    /// True if the accessor whose number is `reference` has a buffer view. Without one, and without
    /// an extension that replaces it, its elements are zeros.
    bool is_stored(const JsonReader& reference) const;

 private:
    using Component = GltfAccessor::Component;
    using Elements = GltfAccessor::Elements;

    bool has_data(const JsonReader& reference) const;
    std::string_view buffer(const JsonReader& reference);
    std::string_view load(const JsonReader& uri);
    std::string_view keep(const JsonReader& uri, std::string bytes);
    Elements elements(const JsonReader& json, std::size_t count, std::size_t size);
    static Component component(const JsonReader& json, std::initializer_list<Component> allowed,
                               const char* expected);
    GltfAccessor accessor(const JsonReader& reference, std::size_t components,
                          std::initializer_list<Component> allowed, const char* expected);

    /// Extensions that compress buffer views.
    static constexpr std::array<const char*, 2> kCompressions{"EXT_meshopt_compression",
                                                              "KHR_meshopt_compression"};

    std::array<bool, kCompressions.size()> is_required_{};
    std::optional<std::string_view> binary_;
    const OpenBuffer& open_;
    std::vector<JsonReader> buffers_, views_, accessors_;
    std::vector<std::optional<std::string_view>> buffer_bytes_;  ///< [buffer] none: not loaded
    std::deque<std::string> owned_;                              ///< loaded bytes
    std::uint64_t loaded_bytes_ = 0;
};

}  // namespace aula
