#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/input/text_cursor.h"
#include "engine/input/utf8.h"
#include "engine/mesh/mesh_builder.h"
#include "engine/mesh/mesh_readers.h"

namespace aula {
namespace {

// The next word of a line of data; empty at its end and at a comment. A backslash continues the
// line on the next one.
std::string_view data_word(TextCursor& cursor) {
    for (;;) {
        std::string_view word = cursor.word_in_line();
        const std::size_t comment = word.find('#');
        if (comment != std::string_view::npos) {
            cursor.rest_of_line();
            return word.substr(0, comment);
        }
        if (word.empty()) return {};
        if (word.back() != '\\') return word;
        word.remove_suffix(1);
        cursor.next_line();
        if (!word.empty()) return word;
    }
}

// The vertex index, from 0, of a corner "v", "v/vt", "v//vn" or "v/vt/vn". Negative numbers count
// backwards from the newest vertex.
std::uint32_t vertex_index(const TextCursor& cursor, std::string_view word,
                           std::size_t vertex_count) {
    constexpr std::int64_t kMax = std::numeric_limits<std::uint32_t>::max();
    std::int64_t number = 0;
    const char* end = word.data() + word.size();
    const auto [rest, error] = std::from_chars(word.data(), end, number);
    if (error == std::errc::invalid_argument || (rest != end && *rest != '/')) {
        cursor.fail(quoted_start(word) + "; expected the number of a vertex");
    }
    const std::int64_t index =
        number < 0 ? static_cast<std::int64_t>(vertex_count) + number : number - 1;
    if (error != std::errc{} || index < 0 || index > kMax) {
        cursor.fail("vertex " + quoted_start(word) + " of " + std::to_string(vertex_count) +
                    "; expected vertices that exist");
    }
    return static_cast<std::uint32_t>(index);
}

// A name may contain spaces and "#"; a "#" between spaces begins a comment.
std::string material_name(std::string_view line) {
    const std::size_t comment = line.find(" # ");
    line = line.substr(0, comment);
    while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
    return utf8_of(line);
}

}  // namespace

ImportedMesh read_obj(std::string_view bytes) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (bytes.starts_with(kByteOrderMark)) bytes.remove_prefix(kByteOrderMark.size());
    MeshBuilder builder;
    std::optional<std::uint32_t> material;
    std::vector<std::uint32_t> face;
    for (TextCursor cursor(bytes); !cursor.at_end(); cursor.next_line()) {
        const std::string_view keyword = cursor.word_in_line();
        if (keyword == "v") {
            const double x = cursor.number(data_word(cursor));
            const double y = cursor.number(data_word(cursor));
            const double z = cursor.number(data_word(cursor));
            builder.add_vertex(x, y, z);
        } else if (keyword == "f") {
            face.clear();
            for (auto word = data_word(cursor); !word.empty(); word = data_word(cursor)) {
                face.push_back(vertex_index(cursor, word, builder.vertex_count()));
            }
            if (!material) material = builder.material(kNamelessMaterial);
            builder.add_face(face, *material);
        } else if (keyword == "usemtl") {
            const std::string name = material_name(cursor.rest_of_line());
            if (!name.empty()) material = builder.material(name);
        }
    }
    return builder.take();
}

}  // namespace aula
