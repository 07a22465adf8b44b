#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "aula/exception.h"
#include "engine/input/scalar_bytes.h"
#include "engine/input/text_cursor.h"
#include "engine/mesh/mesh_builder.h"
#include "engine/mesh/mesh_readers.h"

namespace aula {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
    std::string name;
    Type type = Type::float32;       // of the value, or of the elements of a list
    std::optional<Type> count_type;  // lists only
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    std::optional<std::endian> order;  // none: text
    std::vector<Element> elements;
};

Type read_type(TextCursor& cursor) {
    constexpr const char* kNames[][2] = {
        {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
        {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
    const std::string_view word = cursor.word_in_line();
    for (std::size_t i = 0; i < std::size(kNames); ++i) {
        if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Type>(i);
    }
    cursor.fail(quoted_start(word) + "; expected the type of a property");
}

Property read_property(TextCursor& cursor) {
    Property property;
    TextCursor ahead = cursor;
    if (ahead.word_in_line() == "list") {
        cursor = ahead;
        property.count_type = read_type(cursor);
    }
    property.type = read_type(cursor);
    property.name = cursor.word_in_line();
    return property;
}

std::optional<std::endian> read_format(TextCursor& cursor) {
    const std::string_view format = cursor.word_in_line();
    if (format == "ascii") return std::nullopt;
    if (format == "binary_little_endian") return std::endian::little;
    if (format == "binary_big_endian") return std::endian::big;
    cursor.fail("the format " + quoted_start(format) +
                "; expected ascii, binary_little_endian or binary_big_endian");
}

std::uint64_t whole_number(double value, const char* what) {
    if (!(value >= 0 && value <= std::numeric_limits<std::uint32_t>::max()) ||
        value != std::floor(value)) {
        throw InputError(what +
                         std::string(" is not a whole number from 0 to 2^32 - 1; expected one"));
    }
    return static_cast<std::uint64_t>(value);
}

// Reads the header. The cursor is then after the word end_header.
Header read_header(TextCursor& cursor) {
    if (cursor.word() != "ply") cursor.fail("not a PLY file; expected \"ply\" at its beginning");
    Header header;
    bool has_format = false;
    while (!cursor.at_end()) {
        cursor.next_line();
        const std::string_view keyword = cursor.word_in_line();
        if (keyword == "end_header") {
            if (!has_format) cursor.fail("no format; expected one in the header");
            return header;
        }
        if (keyword == "format") {
            header.order = read_format(cursor);
            has_format = true;
        } else if (keyword == "element") {
            Element& element = header.elements.emplace_back();
            element.name = cursor.word_in_line();
            const double count = cursor.number(cursor.word_in_line());
            element.count = whole_number(count, "the number of an element");
        } else if (keyword == "property") {
            if (header.elements.empty()) cursor.fail("a property of nothing; expected an element");
            header.elements.back().properties.push_back(read_property(cursor));
        }
    }
    throw InputError("its header has no end; expected end_header");
}

class TextValues {
 public:
    explicit TextValues(TextCursor& cursor) : cursor_(cursor) {}
    double next(Type) { return cursor_.number(cursor_.word()); }

 private:
    TextCursor& cursor_;
};

class BinaryValues {
 public:
    BinaryValues(std::string_view bytes, std::endian order) : rest_(bytes), order_(order) {}

    double next(Type type) {
        switch (type) {
            case Type::int8:
                return next_as<std::int8_t>();
            case Type::uint8:
                return next_as<std::uint8_t>();
            case Type::int16:
                return next_as<std::int16_t>();
            case Type::uint16:
                return next_as<std::uint16_t>();
            case Type::int32:
                return next_as<std::int32_t>();
            case Type::uint32:
                return next_as<std::uint32_t>();
            case Type::float32:
                return next_as<float>();
            case Type::float64:
                return next_as<double>();
        }
        return 0;
    }

 private:
    template <class T>
    double next_as() {
        if (rest_.size() < sizeof(T)) {
            throw InputError("its data end early; expected as many as the header states");
        }
        const T value = read_scalar<T>(rest_.data(), order_);
        rest_.remove_prefix(sizeof(T));
        return static_cast<double>(value);
    }

    std::string_view rest_;
    std::endian order_;
};

std::size_t property_index(const Element& element, const char* name) {
    const auto& all = element.properties;
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const Property& p) { return p.name == name && !p.count_type; });
    if (found == all.end()) {
        throw InputError("its vertices have no property " + std::string(name) +
                         "; expected x, y and z");
    }
    return static_cast<std::size_t>(found - all.begin());
}

// Reads one element: its numbers to `scalars`, [property], and the vertices of a face to `face`.
template <class Values>
void read_element(const Element& element, Values& values, std::vector<double>& scalars,
                  std::vector<std::uint32_t>& face) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const Property& property = element.properties[i];
        if (!property.count_type) {
            scalars[i] = values.next(property.type);
            continue;
        }
        const bool is_face = element.name == "face" &&
                             (property.name == "vertex_indices" || property.name == "vertex_index");
        const std::uint64_t count =
            whole_number(values.next(*property.count_type), "a list's size");
        for (std::uint64_t k = 0; k < count; ++k) {
            const double value = values.next(property.type);
            if (!is_face) continue;
            face.push_back(static_cast<std::uint32_t>(whole_number(value, "a face's vertex")));
        }
    }
}

template <class Values>
ImportedMesh read_elements(const Header& header, Values values) {
    MeshBuilder builder;
    const std::uint32_t material = builder.material(kNamelessMaterial);
    std::vector<std::uint32_t> face;
    for (const Element& element : header.elements) {
        if (element.properties.empty()) continue;
        const bool is_vertex = element.name == "vertex";
        std::array<std::size_t, 3> xyz{};
        if (is_vertex) {
            xyz = {property_index(element, "x"), property_index(element, "y"),
                   property_index(element, "z")};
        }
        std::vector<double> scalars(element.properties.size());
        for (std::uint64_t i = 0; i < element.count; ++i) {
            face.clear();
            read_element(element, values, scalars, face);
            if (is_vertex) builder.add_vertex(scalars[xyz[0]], scalars[xyz[1]], scalars[xyz[2]]);
            builder.add_face(face, material);
        }
    }
    return builder.take();
}

// The data after end_header and its line end. If lines end with a single \r, the data may begin
// with \n.
std::string_view data_after_header(std::string_view file, std::string_view rest) {
    const std::size_t first_end = file.find_first_of("\r\n");
    const bool cr_alone = file.substr(first_end, 1) == "\r" && file.substr(first_end, 2) != "\r\n";
    while (!rest.empty() && rest[0] == ' ') rest.remove_prefix(1);
    if (!cr_alone && rest.substr(0, 2) == "\r\n") return rest.substr(2);
    return rest.substr(std::min<std::size_t>(1, rest.size()));
}

}  // namespace

ImportedMesh read_ply(std::string_view bytes) {
    TextCursor cursor(bytes);
    const Header header = read_header(cursor);
    if (!header.order) return read_elements(header, TextValues(cursor));
    const std::string_view data = data_after_header(bytes, cursor.rest());
    return read_elements(header, BinaryValues(data, *header.order));
}

}  // namespace aula
