#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "aula/engine/scene.h"
#include "aula/exception.h"
#include "engine/mesh/mesh_readers.h"
#include "tests/engine/mesh/square_gltf.h"

using aula::Bounds;
using aula::ImportedMesh;
using aula::Vec3;
using aula::test::square_bytes;
using aula::test::square_gltf;
using Catch::Contains;
using Json = nlohmann::json;

namespace {

ImportedMesh read(const std::string& file) {
    return aula::read_gltf(file, [](const std::filesystem::path& name) {
        if (name != "square.bin") throw aula::InputError("not there; expected square.bin");
        return square_bytes();
    });
}

/// The error message; empty if there is no error.
std::string error_of(const std::string& file) {
    try {
        read(file);
    } catch (const aula::InputError& error) {
        const std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        CHECK_THAT(message, Contains("; expected"));
        return message;
    }
    return {};
}

/// The error of the square with the value at a JSON pointer replaced.
std::string error_with(const char* pointer, const char* value) {
    Json json = square_gltf();
    json[Json::json_pointer(pointer)] = Json::parse(value);
    return error_of(json.dump());
}

float area(const ImportedMesh& mesh) {
    float sum = 0;
    const auto& v = mesh.vertices;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += glm::length(glm::cross(v[b] - v[a], v[c] - v[a])) / 2;
    }
    return sum;
}

std::string word(std::uint32_t value) {
    return {static_cast<char>(value), static_cast<char>(value >> 8U),
            static_cast<char>(value >> 16U), static_cast<char>(value >> 24U)};
}

std::string glb(std::string json, const std::string& binary, std::uint32_t binary_size) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string chunks = word(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                               word(binary_size) + std::string("BIN\0", 4) + binary;
    return "glTF" + word(2) + word(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

}  // namespace

TEST_CASE("a glTF's triangles are read from a file, a data URI and a GLB") {
    const ImportedMesh mesh = read(square_gltf().dump());
    CHECK(mesh.triangles.size() == 2);
    CHECK(mesh.vertices.size() == 4);
    CHECK(area(mesh) == Approx(1));
    CHECK(mesh.material_names == std::vector<std::string>{"stone"});
    Json escaped = square_gltf();
    escaped["buffers"][0]["uri"] = "s%71uare%2Ebin";
    CHECK(area(read(escaped.dump())) == Approx(1));
    Json inside = square_gltf();
    inside["buffers"][0].erase("uri");
    CHECK(area(read(glb(inside.dump(), square_bytes(), 60))) == Approx(1));
    std::string padded = inside.dump();
    padded.resize((padded.size() + 7) / 4 * 4, '\0');
    CHECK(area(read(glb(padded, square_bytes(), 60))) == Approx(1));
}

TEST_CASE("triangles of a glTF without a material name have the default name") {
    Json json = square_gltf();
    auto& primitives = json["meshes"][0]["primitives"];
    json["materials"].push_back(Json::object());
    primitives.push_back(primitives[0]);
    primitives[0].erase("material");
    primitives[1]["material"] = 1;
    const ImportedMesh mesh = read(json.dump());
    CHECK(mesh.material_names == std::vector<std::string>{aula::kNamelessMaterial});
    CHECK(mesh.triangles.size() == 4);
}

TEST_CASE("strips and fans are read, points and lines are omitted") {
    const auto with_mode = [](int mode, const char* count) {
        Json json = square_gltf();
        auto& primitive = json["meshes"][0]["primitives"][0];
        primitive["mode"] = mode;
        if (count != nullptr) json["accessors"][1]["count"] = Json::parse(count);
        return json;
    };
    // The corners in order are a fan; a strip of them crosses itself but covers half the square.
    Json fan = with_mode(6, nullptr);
    fan["meshes"][0]["primitives"][0].erase("indices");
    const ImportedMesh mesh = read(fan.dump());
    CHECK(mesh.triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}});
    Json strip = with_mode(5, nullptr);
    strip["meshes"][0]["primitives"][0].erase("indices");
    CHECK(read(strip.dump()).triangles ==
          std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {1, 3, 2}});
    for (const int mode : {0, 1, 2, 3}) {
        CHECK_THAT(error_of(with_mode(mode, "1").dump()), Contains("no triangle"));
    }
    CHECK_THAT(error_of(with_mode(4, "5").dump()), Contains("5 corners; expected a multiple"));
    CHECK_THAT(error_of(with_mode(5, "2").dump()), Contains("2 corners; expected at least 3"));
    CHECK_THAT(error_of(with_mode(6, "1").dump()), Contains("1 corners; expected at least 3"));
    CHECK_THAT(error_of(with_mode(7, nullptr).dump()), Contains("/mode: 7 is out of range"));
}

TEST_CASE("node transforms are a matrix, or scale, rotation and translation, within their parent") {
    Json json = square_gltf();
    // Scaled by 2, rotated by 90 degrees about z and translated, in a parent that mirrors x.
    json["nodes"] = Json::parse(R"([
        {"children": [1], "matrix": [-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]},
        {"mesh": 0, "scale": [2,2,2], "rotation": [0,0,0.7071067811865476,0.7071067811865476],
         "translation": [10,0,0]}])");
    const ImportedMesh mesh = read(json.dump());
    // (1,0,0): scaled (2,0,0), rotated (0,2,0), translated (10,2,0), mirrored (-10,2,5).
    // Rounding of single precision at 10.
    CHECK(glm::distance(mesh.vertices[1], Vec3(-10, 2, 5)) < 1e-5F);
}

TEST_CASE("sparse, interleaved and quantized positions are read") {
    Json sparse = square_gltf();
    // The third corner, (1, 1, 0), is replaced by the second one, (1, 0, 0).
    sparse["accessors"][0]["sparse"] = Json::parse(R"({"count": 1,
        "indices": {"bufferView": 1, "byteOffset": 4, "componentType": 5123},
        "values": {"bufferView": 0, "byteOffset": 12}})");
    CHECK(read(sparse.dump()).triangles.size() == 1);
    CHECK(area(read(sparse.dump())) == Approx(0.5));
    Json interleaved = square_gltf();
    // Every second corner of the square.
    interleaved["bufferViews"][0]["byteStride"] = 24;
    interleaved["accessors"][0]["count"] = 2;
    CHECK_THAT(error_of(interleaved.dump()), Contains("vertex 2 of 2"));
    // The floats' bytes as 16 bits: 1.0F is 0, 0x3f80, so that (0, 0x3f80, 0) is the third of
    // these.
    Json quantized = square_gltf();
    quantized["accessors"][0]["componentType"] = 5123;
    quantized["accessors"][0]["count"] = 8;
    quantized["accessors"][0]["normalized"] = true;
    quantized["meshes"][0]["primitives"][0].erase("indices");
    quantized["accessors"][0]["count"] = 6;
    const ImportedMesh mesh = read(quantized.dump());
    CHECK(mesh.vertices[2].y == 0x3f80 / 65535.0F);
}

TEST_CASE("normalized glTF positions are at least -1") {
    // The fifth position of signed bytes ends with the third byte of a float 1, 0x80.
    Json quantized = square_gltf();
    quantized["accessors"][0]["componentType"] = 5120;
    quantized["accessors"][0]["normalized"] = true;
    quantized["meshes"][0]["primitives"][0].erase("indices");
    quantized["accessors"][0]["count"] = 6;
    const ImportedMesh mesh = read(quantized.dump());
    CHECK(mesh.vertices[4].z == -1);
    CHECK(mesh.vertices[5].x == 63 / 127.0F);
}

TEST_CASE("references of a glTF out of range are refused at their place") {
    struct Change {
        const char* pointer;
        const char* value;
        const char* error;
    };
    for (const auto& [pointer, value, error] : {
             Change{"/scene", "3", "/scene: 3 of 1 scenes"},
             {"/scenes/0/nodes/0", "7", "/scenes/0/nodes/0: 7 of 1 nodes"},
             {"/scenes/0/nodes/0", "-1", "out of range"},
             {"/nodes/0/mesh", "1", "/nodes/0/mesh: 1 of 1 meshes"},
             {"/meshes/0/primitives/0/indices", "2", "2 of 2 accessors"},
             {"/meshes/0/primitives/0/material", "1", "1 of 1 materials"},
             {"/meshes/0/primitives/0/attributes", "{}", "/attributes/POSITION: missing"},
             {"/accessors/0/bufferView", "9", "9 of 2 buffer views"},
             {"/accessors/0/count", "5", "/accessors/0: 5 elements beyond"},
             {"/accessors/0/count", "18446744073709551615", "beyond"},
             {"/accessors/0/byteOffset", "18446744073709551615", "beyond"},
             {"/accessors/0/count", "0", "no elements"},
             {"/accessors/0/type", "\"VEC2\"", "expected VEC3"},
             {"/accessors/1/componentType", "5126", "the type 5126"},
             {"/bufferViews/0/buffer", "1", "1 of 1 buffers"},
             {"/bufferViews/0/byteLength", "61", "bytes beyond"},
             {"/bufferViews/0/byteOffset", "13", "bytes beyond"},
             {"/bufferViews/0/byteOffset", "18446744073709551600", "bytes beyond"},
             {"/bufferViews/0/byteStride", "4", "a stride of 4"},
             {"/buffers/0/byteLength", "61", "a buffer of 60 bytes"},
             {"/nodes/0/matrix", "[1, 2, 3]", "expected 16 numbers"},
             {"/nodes/0/scale", "[1e300, 1e300, 1]", "not finite"},
             {"/asset/version", "\"1.0\"", "expected 2.0"},
             {"/scenes", "[]", "no scene"},
         }) {
        CAPTURE(pointer, value);
        CHECK_THAT(error_with(pointer, value), Contains(error));
    }
}

TEST_CASE("buffers are base64 or files beside the glTF") {
    const auto error_of_uri = [](const std::string& uri) {
        return error_with("/buffers/0/uri", Json(uri).dump().c_str());
    };
    CHECK_THAT(error_of_uri("../square.bin"), Contains("is elsewhere"));
    CHECK_THAT(error_of_uri("%2e%2E/square.bin"), Contains("is elsewhere"));
    CHECK_THAT(error_of_uri("/dev/zero"), Contains("is elsewhere"));
    CHECK_THAT(error_of_uri("other.bin"), Contains("\"other.bin\": not there"));
    CHECK_THAT(error_of_uri("data:application/octet-stream,abc"), Contains("base64"));
    CHECK_THAT(error_of_uri("data:;base64,AAA*"), Contains("base64"));
    CHECK_THAT(error_of_uri("data:;base64,AAAA"), Contains("a buffer of 3 bytes; expected 60"));
    Json json = square_gltf();
    json["buffers"][0].erase("uri");
    CHECK_THAT(error_of(json.dump()), Contains("a buffer without data"));
    // The data of a GLB are those of its first buffer only.
    json["buffers"].push_back(json["buffers"][0]);
    for (Json& view : json["bufferViews"]) view["buffer"] = 1;
    CHECK_THAT(error_of(glb(json.dump(), square_bytes(), 60)), Contains("a buffer without data"));
}

TEST_CASE("of compressed triangles the uncompressed data are read unless a file requires more") {
    const auto with = [](const char* pointer, const char* name) {
        Json json = square_gltf();
        json[Json::json_pointer(pointer)][name] = Json::object();
        json["extensionsUsed"] = {name};
        return json;
    };
    for (const char* const name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        CAPTURE(name);
        Json json = with("/bufferViews/0/extensions", name);
        CHECK(area(read(json.dump())) == Approx(1));
        Json required = json;
        required["extensionsRequired"] = {name};
        CHECK_THAT(error_of(required.dump()), Contains(std::string(name) + " is not read"));
        json["buffers"][0].erase("uri");
        CHECK_THAT(error_of(json.dump()), Contains(std::string(name) + " is not read"));
    }
    const char* const draco = "KHR_draco_mesh_compression";
    Json json = with("/meshes/0/primitives/0/extensions", draco);
    CHECK(area(read(json.dump())) == Approx(1));
    Json required = json;
    required["extensionsRequired"] = {draco};
    CHECK_THAT(error_of(required.dump()), Contains("KHR_draco_mesh_compression is not read"));
    for (Json& accessor : json["accessors"]) accessor.erase("bufferView");
    CHECK_THAT(error_of(json.dump()), Contains("KHR_draco_mesh_compression is not read"));
}

TEST_CASE("a node with instances has its mesh at each of them") {
    const auto with = [](const char* attributes) {
        Json json = square_gltf();
        json["nodes"][0]["translation"] = {0, 0, 5};
        json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
            Json::parse(attributes);
        // The corners' numbers as rotations: by 0, 90 and 180 degrees about z, not normalized.
        json["accessors"].push_back(
            {{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC4"}});
        return json.dump();
    };
    const auto bounds = [](const ImportedMesh& mesh) {
        Bounds all;
        all.add(mesh.vertices);
        return all;
    };
    // At the four corners of the square.
    const ImportedMesh moved = read(with(R"({"TRANSLATION": 0})"));
    CHECK(area(moved) == Approx(4));
    CHECK(bounds(moved).min == Vec3(0, 0, 5));
    CHECK(bounds(moved).max == Vec3(2, 2, 5));
    const ImportedMesh turned = read(with(R"({"ROTATION": 2})"));
    CHECK(area(turned) == Approx(3));
    CHECK(glm::distance(bounds(turned).min, Vec3(-1, -1, 5)) < 1e-6F);
    CHECK(glm::distance(bounds(turned).max, Vec3(1, 1, 5)) < 1e-6F);
    // Of the scales (0, 0), (1, 0), (1, 1) and (0, 1) one leaves an area; scaled, then moved.
    const ImportedMesh scaled = read(with(R"({"SCALE": 0, "TRANSLATION": 0})"));
    CHECK(area(scaled) == Approx(1));
    CHECK(area(read(with("{}"))) == Approx(1));
    CHECK_THAT(error_of(with(R"({"TRANSLATION": 0, "ROTATION": 2})")),
               Contains("ROTATION: 3 instances; expected 4"));
    CHECK_THAT(error_of(with(R"({"TRANSLATION": 9})")), Contains("expected one that exists"));
}

TEST_CASE("nodes of a glTF are a tree of any depth, and text may be nested 100 deep") {
    const auto chain = [](std::size_t count) {
        Json json = square_gltf();
        json["nodes"] = Json::array();
        for (std::size_t i = 1; i < count; ++i) json["nodes"].push_back({{"children", {i}}});
        json["nodes"].push_back({{"mesh", 0}});
        return json;
    };
    CHECK(area(read(chain(100'000).dump())) == Approx(1));
    Json cycle = chain(3);
    cycle["nodes"][2]["children"] = {0};
    CHECK_THAT(error_of(cycle.dump()), Contains("/nodes/2/children/0: a node a second time"));
    // Each node refers to the next one twice: 2^30 paths to the last one.
    Json ladder = chain(30);
    for (std::size_t i = 0; i + 1 < 30; ++i) ladder["nodes"][i]["children"] = {i + 1, i + 1};
    CHECK_THAT(error_of(ladder.dump()), Contains("a second time"));
    CHECK_THAT(error_of(std::string(200'000, '[')), Contains("nested too deeply"));
    CHECK_THAT(error_of(R"({"extras": )" + std::string(200'000, '[')), Contains("nested"));
}

TEST_CASE("a glTF with too many instances of its triangles is refused") {
    Json json = square_gltf();
    // 3000 nodes, each with the same primitive 3000 times.
    const Json primitive = json["meshes"][0]["primitives"][0];
    json["meshes"][0]["primitives"] = Json(3000, primitive);
    json["nodes"] = Json(3000, Json{{"mesh", 0}});
    json["scenes"][0]["nodes"] = Json::array();
    for (int i = 0; i < 3000; ++i) json["scenes"][0]["nodes"].push_back(i);
    CHECK_THAT(error_of(json.dump()), Contains("more than 1000000 primitives"));
    CHECK_THAT(error_with("/accessors/0", R"({"componentType": 5126, "count": 1000000000,
                   "type": "VEC3", "sparse": {"count": 1, "indices": {"bufferView": 1,
                   "componentType": 5123}, "values": {"bufferView": 0}}})"),
               Contains("1000000000 vertices; expected at most"));
}

TEST_CASE("GLB files that are truncated or of another version are refused") {
    Json json = square_gltf();
    json["buffers"][0].erase("uri");
    const std::string file = glb(json.dump(), square_bytes(), 60);
    // A chunk that ends 8 bytes beyond the file.
    CHECK_THAT(error_of(glb(json.dump(), square_bytes().substr(8), 60)), Contains("truncated"));
    for (std::size_t size = 4; size < file.size(); ++size) {
        CHECK_FALSE(error_of(file.substr(0, size)).empty());
    }
    CHECK_THAT(error_of("glTF" + word(1) + file.substr(8)), Contains("version 2"));
    CHECK_THAT(error_of("this is no mesh"), Contains("line 1"));
    CHECK_FALSE(error_of("").empty());
}

TEST_CASE("the scale of a node has a factor per axis") {
    Json json = square_gltf();
    json["nodes"] = Json::parse(R"([{"mesh": 0, "scale": [2, 3, 5]}])");
    const ImportedMesh plain = read(square_gltf().dump());
    const ImportedMesh mesh = read(json.dump());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        CHECK(mesh.vertices[i] == plain.vertices[i] * Vec3(2, 3, 5));  // exact: integers
}
