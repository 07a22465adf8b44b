#include "engine/mesh/mesh_import.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>

#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "tests/engine/mesh/square_gltf.h"
#include "tests/support/temporary_folder.h"

using aula::Vec3;
using aula::test::TemporaryFolder;
using Catch::Contains;

namespace {

constexpr const char* kQuadObj =
    "mtllib none.mtl\n"
    "v 0 0 0\nv 2 0 0\nv 2 0 1\nv 0 0 1\nv 0 3 0\n"
    "usemtl stone\nf 1 2 3 4\nusemtl glass\nf 1 2 5\n";

constexpr const char* kTrianglePly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 0 1\n3 0 1 2\n";

constexpr const char* kTriangleStl =
    "solid wall\nfacet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\n"
    "endloop\nendfacet\nendsolid wall\n";

std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const bool there = i + k < bytes.size();
            group = group << 8U | (there ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
        }
    }
    return text;
}

// The square in a node translated by (0, 5, 0), in a parent scaled by 2; its bytes are at `uri`.
std::string moved_square(const std::string& uri) {
    nlohmann::json json = aula::test::square_gltf();
    json["nodes"] = nlohmann::json::parse(
        R"([{"scale": [2, 2, 2], "children": [1]}, {"mesh": 0, "translation": [0, 5, 0]}])");
    json["buffers"][0]["uri"] = uri;
    return json.dump();
}

std::string moved_square() {
    return moved_square("data:application/octet-stream;base64," +
                        base64(aula::test::square_bytes()));
}

aula::ImportedMesh import(const std::string& name, const std::string& content) {
    const TemporaryFolder folder;
    return aula::import_mesh(folder.write(name, content));
}

std::string reason(const std::string& name, const std::string& content) {
    try {
        import(name, content);
    } catch (const aula::InputError& error) {
        return error.what();
    }
    return {};
}

bool has_vertex(const std::vector<Vec3>& vertices, const Vec3& v) {
    return std::any_of(vertices.begin(), vertices.end(),
                       [&](const Vec3& x) { return glm::distance(x, v) < 1e-6F; });
}

aula::LoadedScene load(const TemporaryFolder& folder, const std::string& geometry) {
    return aula::load_scene(
        folder.write("scene.json", R"({"aula": 1, "sources": [{"position": [0, 0, 0]}],
            "listener": {"position": [0, 0, 0]},
            "materials": {"soft": {"absorption": 0.9}}, "geometry": [{)" +
                                       geometry + "}]}"));
}

std::string error_of(const TemporaryFolder& folder, const std::string& geometry) {
    try {
        load(folder, geometry);
    } catch (const aula::InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("an OBJ's polygons are triangulated and its material names kept without an MTL file") {
    const aula::ImportedMesh mesh = import("quad.obj", kQuadObj);
    CHECK(mesh.triangles.size() == 3);
    std::size_t glass = 0;
    for (const auto material : mesh.triangle_materials) {
        glass += mesh.material_names[material] == "glass" ? 1 : 0;
    }
    CHECK(glass == 1);
    CHECK(has_vertex(mesh.vertices, {2, 0, 1}));
}

TEST_CASE("triangles are read from PLY, STL and glTF") {
    CHECK(import("a.ply", kTrianglePly).triangles.size() == 1);
    CHECK(import("a.stl", kTriangleStl).triangles.size() == 1);
    CHECK(import("a.gltf", moved_square()).triangles.size() == 2);
}

TEST_CASE("the transforms of glTF nodes are applied from the root down") {
    const aula::ImportedMesh mesh = import("a.gltf", moved_square());
    CHECK(has_vertex(mesh.vertices, {0, 10, 0}));
    CHECK(has_vertex(mesh.vertices, {2, 10, 0}));
    CHECK(mesh.material_names.at(mesh.triangle_materials.at(0)) == "stone");
}

TEST_CASE("triangles without area are omitted, a mesh without other triangles is refused") {
    const std::string flat = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n";
    CHECK_THAT(reason("flat.obj", flat), Contains("no triangle"));
    CHECK(import("one.obj", flat + "f 1 2 4\n").triangles.size() == 1);
    // A height of 5e-8 of the longest side, in any order of the corners.
    for (const char* corners : {"1 2 3", "2 3 1", "3 1 2"}) {
        const std::string needle = "v 0 1e-7 0\nv -1 0 0\nv 1 0 0\n";
        CHECK_THAT(reason("needle.obj", needle + "f " + corners + "\n"), Contains("no triangle"));
    }
}

TEST_CASE("invalid meshes are refused with the reason") {
    CHECK_THAT(reason("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Contains("finite"));
    CHECK_FALSE(reason("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n").empty());
    CHECK_FALSE(reason("text.glb", "this is no mesh").empty());
    CHECK_FALSE(reason("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n# no face here\n").empty());
    CHECK_THAT(reason("mesh.fbx", "x"), Contains("\".fbx\" are not read; expected OBJ"));
    CHECK_THAT(reason("mesh", "x"), Contains("expected OBJ"));
    CHECK_THAT(reason("endless.ply", "ply\nformat ascii 1.0\nelement vertex 3\nend_headers\n"),
               Contains("end_header"));
    CHECK(import("CAPITALS.OBJ", kQuadObj).triangles.size() == 3);
}

TEST_CASE("pipes, sockets, folders and devices are refused as meshes and buffers without waiting") {
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& name) {
        REQUIRE(std::filesystem::exists(folder.path() / name));
        for (const char* extension : {".obj", ".ply", ".stl", ".glb", ".gltf"}) {
            const auto mesh = folder.path() / (name + extension);
            std::filesystem::create_symlink(name, mesh);
            CHECK_THROWS_WITH(aula::import_mesh(mesh), Contains("not a regular file; expected"));
            std::filesystem::remove(mesh);
        }
        CHECK_THROWS_WITH(aula::import_mesh(folder.write("b.gltf", moved_square(name))),
                          Contains("/buffers/0/uri") && Contains("not a regular file"));
    };
    REQUIRE(mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    refused("pipe");
    std::filesystem::create_symlink("/dev/zero", folder.path() / "zero");
    refused("zero");
    std::filesystem::create_directory(folder.path() / "folder");
    refused("folder");
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    (folder.path() / "socket").string().copy(address.sun_path, sizeof address.sun_path - 1);
    const int socket_fd = socket(AF_UNIX, SOCK_STREAM, 0);
    REQUIRE(bind(socket_fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    refused("socket");
    close(socket_fd);
    // An MTL file that is a pipe is not opened.
    const auto obj = folder.write("m.obj", std::string("mtllib pipe\n") + kQuadObj);
    CHECK(aula::import_mesh(obj).triangles.size() == 3);
}

TEST_CASE("a mesh file above the limit is refused before it is read") {
    const TemporaryFolder folder;
    const auto file = folder.write("large.obj", kQuadObj);
    std::filesystem::resize_file(file, aula::kMaxMeshBytes + 1);  // sparse
    CHECK_THROWS_WITH(aula::import_mesh(file), Contains("1073741825 bytes; expected at most"));
}

TEST_CASE("buffers in the folder of the glTF and below are read") {
    const TemporaryFolder folder;
    std::filesystem::create_directory(folder.path() / "data");
    folder.write("data/a b.bin", aula::test::square_bytes());
    const auto file = folder.write("a.gltf", moved_square("data/a%20b.bin"));
    CHECK(aula::import_mesh(file).triangles.size() == 2);
}

TEST_CASE("a concave polygon of a mesh file is covered once") {
    const aula::ImportedMesh mesh =
        import("l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 4 5 6 1 2 3\n");
    float area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto& v = mesh.vertices;
        area += glm::length(glm::cross(v[b] - v[a], v[c] - v[a])) / 2;
    }
    CHECK(area == Approx(3));
}

TEST_CASE("a face with too few or repeated corners does not affect the others") {
    const aula::ImportedMesh mesh =
        import("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 1 1 1\nf 1 2\nf 1 2 3\nf 1 2 1 2\n");
    CHECK(mesh.triangles.size() == 1);
}

TEST_CASE("glTF is y up and other formats are z up unless the scene specifies an axis") {
    const TemporaryFolder folder;
    folder.write("a.gltf", moved_square());
    folder.write("a.obj", kQuadObj);
    const auto vertices = [&](const std::string& geometry) {
        return load(folder, geometry + R"(, "default_material": "soft")").scene.objects[0].vertices;
    };
    CHECK(has_vertex(vertices(R"("file": "a.gltf")"), {2, 0, 10}));
    CHECK(has_vertex(vertices(R"("file": "a.gltf", "up": "z")"), {2, 10, 0}));
    CHECK(has_vertex(vertices(R"("file": "a.obj")"), {0, 3, 0}));
    CHECK(has_vertex(vertices(R"("file": "a.obj", "up": "y")"), {0, 0, 3}));
}

TEST_CASE("mesh materials are mapped, otherwise found by name, otherwise the default") {
    const TemporaryFolder folder;
    folder.write("a.obj", kQuadObj);
    const auto names = [&](const std::string& geometry) {
        const aula::Scene scene = load(folder, R"("file": "a.obj", )" + geometry).scene;
        std::vector<std::string> result;
        for (const auto m : scene.objects[0].triangle_materials) {
            result.push_back(scene.materials[m].name);
        }
        std::sort(result.begin(), result.end());
        return result;
    };
    using Names = std::vector<std::string>;
    CHECK(names(R"("materials": {"stone": "soft"})") == Names{"glass", "soft", "soft"});
    CHECK(names(R"("materials": {"glass": "soft"})") == Names{"soft", "stone", "stone"});
    CHECK(names(R"("default_material": "soft")") == Names{"glass", "stone", "stone"});
    CHECK(names(R"("material": "soft")") == Names{"soft", "soft", "soft"});
}

TEST_CASE("unmapped materials are one error that lists them all") {
    const TemporaryFolder folder;
    folder.write("a.obj",
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl part_3\nf 1 2 3\nusemtl pipe\nf 1 2 3\n");
    const std::string error = error_of(folder, R"("file": "a.obj")");
    CHECK_THAT(error, Contains("scene.json: /geometry/0: the mesh's materials"));
    CHECK_THAT(error, Contains("\"part_3\"") && Contains("\"pipe\""));
    CHECK_THAT(error, !Contains("did you mean"));
    CHECK(load(folder, R"("file": "a.obj", "default_material": "soft")").warnings.empty());
}

TEST_CASE("unmapped materials near a known name are listed with it, ignoring case") {
    const TemporaryFolder folder;
    folder.write("a.obj",
                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl GLASS\nf 1 2 3\nusemtl Softt\nf 1 2 3\n"
                 "usemtl pipe\nf 1 2 3\n");
    CHECK_THAT(error_of(folder, R"("file": "a.obj")"),
               Contains("the mesh's materials \"GLASS\", \"Softt\", \"pipe\" are not known, did "
                        "you mean \"glass\" for \"GLASS\", \"soft\" for \"Softt\"?; expected"));
}

TEST_CASE("mapping a name that the mesh lacks is a warning that lists its names") {
    const TemporaryFolder folder;
    folder.write("a.obj", kQuadObj);
    const auto warnings =
        load(folder, R"("file": "a.obj", "materials": {"ston": "soft"})").warnings;
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("/geometry/0/materials/ston: the mesh has no material") &&
                                Contains("did you mean \"stone\"?; it has \"stone\", \"glass\""));
}

TEST_CASE("errors of mesh files name the scene file, the place and the reason") {
    const TemporaryFolder folder;
    folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    folder.write("a.obj", kQuadObj);
    CHECK_THAT(error_of(folder, R"("file": "none.obj")"),
               Contains("scene.json: /geometry/0/file: no such file") && Contains("none.obj"));
    CHECK_THAT(error_of(folder, R"("file": "bad.obj")"),
               Contains("/geometry/0/file: cannot use the mesh") && Contains("bad.obj"));
    CHECK_THAT(
        error_of(folder, R"("file": "a.obj", "material": "soft", "default_material": "soft")"),
        Contains("/geometry/0/default_material: cannot be combined"));
    CHECK_THAT(error_of(folder, R"("file": "a.obj", "materials": {"stone": "nougat"})"),
               Contains("/geometry/0/materials/stone: unknown material \"nougat\"; expected"));
    CHECK_THAT(error_of(folder, R"("file": "a.obj", "scale": 1e6)"),
               Contains("/geometry/0: a vertex is more than 1e6 m"));
}
