#include "engine/mesh/mesh_builder.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "aula/exception.h"
#include "engine/mesh/polygon.h"

using namespace aula;

TEST_CASE("a mesh has at most 20 million triangles") {
    // A face of n corners is n - 2 triangles.
    constexpr std::uint64_t kPerFace = kMaxCorners - 2;
    const std::vector<std::uint32_t> corners(kMaxCorners);
    MeshBuilder builder;
    for (std::uint64_t i = 0; i < kMaxMeshTriangles / kPerFace; ++i) builder.add_face(corners, 0);
    CHECK_NOTHROW(builder.add_face(std::span(corners).first(kMaxMeshTriangles % kPerFace + 2), 0));
    CHECK_THROWS_AS(builder.add_face(std::span(corners).first(3), 0), InputError);
}

TEST_CASE("a mesh may have more vertices than triangles") {
    MeshBuilder builder;
    for (std::uint64_t i = 0; i < kMaxMeshTriangles + 2; ++i) builder.add_vertex(0, 0, 0);
    CHECK(builder.vertex_count() == kMaxMeshTriangles + 2);
}

TEST_CASE("a needle is omitted if its height is below 1e-7 of its longest side") {
    const auto triangles = [](double height) {
        MeshBuilder builder;
        builder.add_vertex(0, 0, 0);
        builder.add_vertex(1, 0, 0);
        builder.add_vertex(0.999, height, 0);
        builder.add_vertex(0, 1, 0);
        const std::uint32_t material = builder.material("");
        builder.add_face(std::array{0U, 1U, 2U}, material);
        builder.add_face(std::array{0U, 1U, 3U}, material);
        return builder.take().triangles.size();
    };
    CHECK(triangles(0.9e-7) == 1);
    CHECK(triangles(1.1e-7) == 2);
}
