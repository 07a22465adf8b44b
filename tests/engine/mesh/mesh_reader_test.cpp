#include "engine/mesh/mesh_readers.h"

#include <catch2/catch.hpp>
#include <clocale>
#include <cstring>
#include <glm/geometric.hpp>
#include <tuple>

#include "aula/exception.h"
#include "engine/mesh/polygon.h"

namespace mesh_reader_test {

using aula::ImportedMesh;
using aula::Vec3;
using Catch::Contains;

namespace {

template <class T>
std::string bytes_of(T value, bool big_endian = false) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string repeated(const std::string& part, std::size_t times) {
    std::string text;
    text.reserve(part.size() * times);
    for (std::size_t i = 0; i < times; ++i) text += part;
    return text;
}

/// The error message; empty if there is no error.
template <class Read>
std::string error_of(const Read& read) {
    try {
        read();
    } catch (const aula::InputError& error) {
        const std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        CHECK_THAT(message, Contains("; expected"));
        return message;
    }
    return {};
}

std::string obj_error(const std::string& text) {
    return error_of([&] { aula::read_obj(text); });
}
std::string ply_error(const std::string& text) {
    return error_of([&] { aula::read_ply(text); });
}
std::string stl_error(const std::string& text) {
    return error_of([&] { aula::read_stl(text); });
}

float area(const ImportedMesh& mesh) {
    float sum = 0;
    const auto& v = mesh.vertices;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += glm::length(glm::cross(v[b] - v[a], v[c] - v[a])) / 2;
    }
    return sum;
}

bool are_same(const ImportedMesh& a, const ImportedMesh& b) {
    return std::tie(a.vertices, a.triangles, a.triangle_materials, a.material_names) ==
           std::tie(b.vertices, b.triangles, b.triangle_materials, b.material_names);
}

constexpr const char* kObjTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

}  // namespace

TEST_CASE("an OBJ may contain comments after data, any line ends, tabs and continued lines") {
    const ImportedMesh plain = aula::read_obj(kObjTriangle);
    for (const char* text : {
             "v 0 0 0 # Vertex 1\nv 1 0 0 #2\nv 0 1 0\nf 1 2 3 # the face\n",
             "v 0 0 0#1\nv 1 0 0\nv 0 1 0#3 4\nf 1 2 3#4\n",
             "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
             "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
             "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3",
             "v\t0\t0\t0\n  v 1 0 0\nv 0 1 0\n\tf\t1  2\t3 ",
             "v 0 0 0\nv 1 \\\n0 0\nv 0 1 0\nf 1\\\r\n2 3",
             "v +0 0.0 -0\nv 1.e0 0 .0 1.0\nv 0 1 0 0.5 0.5 0.5\nf 1/1 2/1/1 3//1\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf -3 -2/-1 -1\n",
             "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",
             "# ends in a backslash \\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 1\nf 1 2 3\n",
         }) {
        INFO(text);
        CHECK(are_same(aula::read_obj(text), plain));
    }
}

TEST_CASE("numbers of an OBJ have a decimal point in every locale") {
    const char* const before = std::setlocale(LC_NUMERIC, nullptr);
    const std::string restored = before == nullptr ? "C" : before;
    std::setlocale(LC_NUMERIC, "de_DE.UTF-8");  // if installed
    const ImportedMesh mesh = aula::read_obj("v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    std::setlocale(LC_NUMERIC, restored.c_str());
    CHECK(mesh.vertices[0].x == 0.5F);
}

TEST_CASE("coordinates that are not finite are refused") {
    CHECK_THAT(obj_error("v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Contains("not finite"));
    CHECK_THAT(obj_error("v 0 inf 0\n"), Contains("vertex 1 is not finite"));
    CHECK_THAT(obj_error("v 0 0 1e39\n"), Contains("vertex 1 is not finite"));
    CHECK_THAT(obj_error("v 0 0 0\nv 1e400 0 0\n"), Contains("line 2") && Contains("range"));
    CHECK_THAT(obj_error("\r\n\r\nv 1,5 0 0\n"), Contains("line 3: \"1,5\"; expected a number"));
    CHECK_THAT(obj_error("v 0 0\n"), Contains("line 1: the line ends; expected a number"));
    CHECK_THAT(obj_error("v 0 0 # 0\n"), Contains("the line ends"));
    CHECK_THAT(obj_error("v 0x10 0 0\n"), Contains("0x10"));
    // The message contains a bounded part of the word.
    CHECK(obj_error("v " + std::string(100'000, 'x') + "\n").size() < 200);
}

TEST_CASE("corners of an OBJ without a vertex are refused with the line") {
    const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    CHECK_THAT(obj_error(vertices + "f 1 2 3\nf 1 2 4\n"),
               Contains("face 2 refers to vertex 4 of 3"));
    CHECK_THAT(obj_error(vertices + "f 0 1 2\n"), Contains("line 4: vertex \"0\" of 3"));
    CHECK_THAT(obj_error(vertices + "f -4 1 2\n"), Contains("line 4: vertex \"-4\" of 3"));
    CHECK_THAT(obj_error(vertices + "f 1 2 99999999999999999999\n"), Contains("line 4"));
    CHECK_THAT(obj_error(vertices + "f 1 2 4294967296\n"), Contains("refers to vertex"));
    CHECK_THAT(obj_error(vertices + "f 1 2 4294967297\n"), Contains("line 4"));
    CHECK_THAT(obj_error(vertices + "f a b c\n"), Contains("line 4: \"a\""));
}

TEST_CASE("material names of an OBJ may contain spaces, number signs and Latin-1") {
    const std::string vertices = "mtllib /dev/zero none.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const ImportedMesh mesh =
        aula::read_obj(vertices +
                       "f 1 2 3\nusemtl Material #25 \nf 1 2 3\nusemtl a b # comment\nf 1 2 3\n"
                       "usemtl\nf 1 2 3\nusemtl \xff\xfe\nf 1 2 3\n");
    CHECK(mesh.material_names ==
          std::vector<std::string>{aula::kNamelessMaterial, "Material #25", "a b", "ÿþ"});
    CHECK(mesh.triangle_materials == std::vector<std::uint32_t>{0, 1, 2, 2, 3});
}

TEST_CASE("a face of more corners than the limit is refused, one at the limit is triangulated") {
    std::string vertices;
    std::string face = "f";
    for (std::size_t i = 0; i < aula::kMaxCorners; ++i) {
        // A comb: neighbours prevent cutting off every second corner.
        vertices += "v " + std::to_string(i) + (i % 2 == 0 ? " 100 0\n" : " 200 0\n");
        face += " " + std::to_string(i + 1);
    }
    vertices += "v 4096 0 0\nv -1 0 0\n";
    const std::string comb = vertices + face;
    CHECK_THAT(obj_error(comb + " 4097 4098\n"), Contains("face 1 has 4098 corners"));
    const std::size_t cut = comb.rfind(" 4095");
    const ImportedMesh mesh = aula::read_obj(comb.substr(0, cut) + " 4097 4098\n");
    // Teeth of mean height 150 over 4093 m, and the triangles of both ends. Rounding of 4093 areas.
    CHECK(area(mesh) == Approx(4093 * 150 + 300 + 50));
    CHECK(obj_error(vertices + "f" + repeated(" 1", 3'000'000) + "\n").size() < 200);
}

TEST_CASE("a PLY gives the same triangles as text and in both byte orders") {
    const auto header = [](const std::string& format) {
        return "ply\nformat " + format +
               " 1.0\ncomment c\nelement vertex 4\nproperty double y\nproperty float x\n"
               "property list uchar short tags\nproperty int8 z\nelement face 2\n"
               "property uchar kind\nproperty list uint8 int vertex_indices\nend_header\n";
    };
    const ImportedMesh text = aula::read_ply(
        header("ascii") + "0 0 0 3\n0 1 2 7 -8 3\n1 1 0 3\n1 0 0 3\n9 4 0 1 2 3\n9 3\n0\n1 2\n");
    REQUIRE(text.triangles.size() == 3);
    CHECK(text.vertices[1] == Vec3(1, 0, 3));
    CHECK(area(text) == Approx(1.5));
    for (const bool big : {false, true}) {
        std::string data = header(big ? "binary_big_endian" : "binary_little_endian");
        for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
            data += bytes_of(static_cast<double>(y), big) + bytes_of(static_cast<float>(x), big);
            const bool tagged = x == 1 && y == 0;
            data += tagged ? bytes_of(std::uint8_t{2}) : bytes_of(std::uint8_t{0});
            if (tagged) data += bytes_of(std::int16_t{7}, big) + bytes_of(std::int16_t{-8}, big);
            data += bytes_of(std::int8_t{3});
        }
        data += "\x09\x04";
        for (const int i : {0, 1, 2, 3}) data += bytes_of(i, big);
        data += "\x09\x03";
        for (const int i : {0, 1, 2}) data += bytes_of(i, big);
        CHECK(are_same(aula::read_ply(data), text));
        CHECK_THAT(ply_error(data.substr(0, data.size() - 1)), Contains("end early"));
    }
}

TEST_CASE("the data of a PLY with carriage returns as line ends may begin with a line feed") {
    const auto file = [](const std::string& end) {
        std::string text;
        for (const char* line :
             {"ply", "format binary_little_endian 1.0", "element face 1",
              "property list uchar uchar vertex_index", "element vertex 10", "property float x",
              "property float y", "property float z", "end_header"}) {
            text += line + end;
        }
        // A face of ten ('\n') corners.
        text += "\n";
        for (char i = 0; i < 10; ++i) text += i;
        for (int i = 0; i < 10; ++i) {
            const auto x = static_cast<float>(i);
            text += bytes_of(x) + bytes_of(x * x) + bytes_of(0.0F);
        }
        return text;
    };
    for (const char* end : {"\n", "\r\n", "\r"}) {
        CHECK(aula::read_ply(file(end)).triangles.size() == 8);
    }
}

TEST_CASE("PLY files with an invalid header or short data are refused quickly") {
    const std::string ascii = "ply\nformat ascii 1.0\n";
    CHECK_THAT(ply_error("PLY\nformat ascii 1.0\nelement vertex 3\n"), Contains("not a PLY file"));
    CHECK_THAT(ply_error(ascii + "element vertex 3\nend_headers\n"), Contains("end_header"));
    CHECK_THAT(ply_error("ply\rformat ascii 1.0\relement vertex 3\rproperty\r\r\rfloat x\r"),
               Contains("the type of a property"));
    CHECK_THAT(ply_error("ply\nend_header\n"), Contains("no format"));
    CHECK_THAT(ply_error("ply\nformat binary_middle_endian 1.0\n"), Contains("binary_middle"));
    CHECK_THAT(ply_error(ascii + "property float x\n"), Contains("a property of nothing"));
    CHECK_THAT(ply_error(ascii + "element vertex 1e300\nend_header\n"), Contains("whole number"));
    CHECK_THAT(ply_error(ascii + "element vertex 1\nproperty float x\nend_header\n0\n"),
               Contains("no property y"));
    CHECK_THAT(ply_error(ascii + "element nothing 4294967295\nend_header\n"),
               Contains("no triangle"));
    const std::string face = "element face 4294967295\nproperty list uint int vertex_index\n";
    CHECK_THAT(ply_error(ascii + face + "end_header\n4294967295 0 1 2\n"),
               Contains("expected a number"));
    CHECK_THAT(ply_error(ascii + face + "end_header\n3 0 1 -2\n"), Contains("whole number"));
}

TEST_CASE("a binary STL is identified by its size even if it begins with \"solid\"") {
    std::string triangle;
    for (const float x : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) {
        triangle += bytes_of(x);
    }
    triangle += "\x01\x02";
    const auto file = [&](std::string header, std::uint32_t count) {
        header.resize(80, ' ');
        return header + bytes_of(count) + triangle + triangle;
    };
    CHECK(aula::read_stl(file("made by", 1).substr(0, 134)).triangles.size() == 1);
    CHECK_THAT(stl_error(file("made by", 0).substr(0, 84)), Contains("no triangle"));
    CHECK(aula::read_stl(file("solid wall", 2)).triangles.size() == 2);
    CHECK(aula::read_stl(file("made by", 2) + "extra").triangles.size() == 2);
    CHECK_THAT(stl_error(file("made by", 3)), Contains("184 bytes; expected 234"));
    CHECK_THAT(stl_error(file("made by", 4294967295)), Contains("184 bytes; expected"));
    CHECK_THAT(stl_error(file("solid wall", 3)), Contains("184 bytes; expected 234"));
    CHECK_THAT(stl_error(file("solid wall", 2).substr(0, 150)), Contains("150 bytes"));
    CHECK_THAT(stl_error("short"), Contains("at least 84"));
    CHECK_THAT(stl_error(""), Contains("0 bytes"));
}

TEST_CASE("a text STL may have capitals, several solids and any normals") {
    const std::string facet =
        "  FACET NORMAL nan nan nan\n OUTER LOOP\n VERTEX 0 0 0\n VERTEX 1 0 0\n vertex 0 1e0 0\n"
        " ENDLOOP\n ENDFACET\n";
    const std::string solid = "solid of vertex and loop\r\n" + facet + "endsolid vertex\r\n";
    CHECK(aula::read_stl(solid + solid).triangles.size() == 2);
    CHECK_THAT(stl_error("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                         "endloop\n"),
               Contains("line 6: a loop without 3 vertices"));
    CHECK_THAT(stl_error("solid\nvertex 0 0 0\n"), Contains("line 2"));
    CHECK_THAT(stl_error("solid\nouter loop\nouter loop\n"), Contains("line 3"));
    CHECK_THAT(stl_error("solid\nouter loop\nvertex 0 0 0\n"), Contains("ends within a loop"));
    CHECK_THAT(stl_error("solid\nnonsense\n"), Contains("\"nonsense\""));
    CHECK_THAT(stl_error("solid\n"), Contains("no triangle"));
}

TEST_CASE("a face that intersects itself is a fan about its first corner") {
    // The corners of a square in the order of an hourglass, and a fifth one that closes it.
    const ImportedMesh mesh =
        aula::read_obj("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4\nf 5 3 2 1 4\n");
    REQUIRE(
        aula::triangulate({mesh.vertices[0], mesh.vertices[1], mesh.vertices[2], mesh.vertices[3]})
            .empty());
    CHECK(mesh.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
    CHECK(mesh.triangles[1] == std::array<std::uint32_t, 3>{0, 2, 3});
}

}  // namespace mesh_reader_test
