#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>

#include "aula/exception.h"
#include "engine/input/scalar_bytes.h"
#include "engine/input/text_cursor.h"
#include "engine/mesh/mesh_builder.h"
#include "engine/mesh/mesh_readers.h"

namespace aula {
namespace {

constexpr std::size_t kHeaderBytes = 84;    // 80 arbitrary bytes, then the number of triangles
constexpr std::size_t kTriangleBytes = 50;  // normal, 3 corners, 2 bytes of attributes

bool is_word(std::string_view word, std::string_view lower_case) {
    return std::equal(word.begin(), word.end(), lower_case.begin(), lower_case.end(),
                      [](unsigned char a, char b) { return std::tolower(a) == b; });
}

void add_triangle(MeshBuilder& builder, std::uint32_t material) {
    const auto end = static_cast<std::uint32_t>(builder.vertex_count());
    builder.add_face(std::array{end - 3, end - 2, end - 1}, material);
}

ImportedMesh read_binary(std::string_view bytes, std::size_t triangles) {
    MeshBuilder builder;
    const std::uint32_t material = builder.material(kNamelessMaterial);
    for (std::size_t i = 0; i < triangles; ++i) {
        const char* normal = bytes.data() + kHeaderBytes + i * kTriangleBytes;
        for (std::size_t corner = 1; corner <= 3; ++corner) {
            const auto coordinate = [&](std::size_t axis) {
                return read_scalar<float>(normal + sizeof(float) * (3 * corner + axis),
                                          std::endian::little);
            };
            builder.add_vertex(coordinate(0), coordinate(1), coordinate(2));
        }
        add_triangle(builder, material);
    }
    return builder.take();
}

ImportedMesh read_text(std::string_view bytes) {
    MeshBuilder builder;
    const std::uint32_t material = builder.material(kNamelessMaterial);
    TextCursor cursor(bytes);
    bool in_loop = false;
    int corners = 0;  // of the present loop
    for (auto word = cursor.word(); !word.empty(); word = cursor.word()) {
        if (is_word(word, "vertex")) {
            const double x = cursor.number(cursor.word_in_line());
            const double y = cursor.number(cursor.word_in_line());
            const double z = cursor.number(cursor.word_in_line());
            if (!in_loop || ++corners > 3) {
                cursor.fail("a vertex outside a loop of 3; expected \"outer loop\"");
            }
            builder.add_vertex(x, y, z);
        } else if (is_word(word, "outer")) {
            if (in_loop) cursor.fail("a loop within a loop; expected \"endloop\"");
            in_loop = true;
            corners = 0;
            cursor.next_line();
        } else if (is_word(word, "endloop")) {
            if (!in_loop || corners != 3) cursor.fail("a loop without 3 vertices; expected 3");
            in_loop = false;
            add_triangle(builder, material);
        } else if (is_word(word, "solid") || is_word(word, "facet") || is_word(word, "endfacet") ||
                   is_word(word, "endsolid")) {
            cursor.next_line();  // names and normals
        } else {
            cursor.fail(quoted_start(word) + "; expected a keyword of STL");
        }
    }
    if (in_loop) cursor.fail("the file ends within a loop; expected \"endloop\"");
    return builder.take();
}

}  // namespace

// The header of a binary file may begin with "solid", too: the size of the file decides, and a text
// has no zero bytes.
ImportedMesh read_stl(std::string_view bytes) {
    const bool text =
        is_word(TextCursor(bytes).word(), "solid") && bytes.find('\0') == std::string_view::npos;
    if (bytes.size() >= kHeaderBytes) {
        const std::size_t triangles =
            read_scalar<std::uint32_t>(bytes.data() + kHeaderBytes - 4, std::endian::little);
        const std::size_t size = kHeaderBytes + triangles * kTriangleBytes;
        if (size == bytes.size() || (!text && size < bytes.size())) {
            return read_binary(bytes, triangles);
        }
        if (!text) {
            throw InputError("it holds " + std::to_string(bytes.size()) + " bytes; expected " +
                             std::to_string(size) + " for its " + std::to_string(triangles) +
                             " triangles, or a text that begins with \"solid\"");
        }
    }
    if (!text) {
        throw InputError("it holds " + std::to_string(bytes.size()) +
                         " bytes; expected at least 84, or a text that begins with \"solid\"");
    }
    return read_text(bytes);
}

}  // namespace aula
