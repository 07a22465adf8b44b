#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "aula.h"

namespace aula::test {

/// A box of 6 m x 4 m x 3 m as arrays of the C interface.
struct BoxMesh {
    BoxMesh() {
        for (int i = 0; i < 8; ++i)
            vertices.insert(vertices.end(),
                            {i & 1 ? 6.0F : 0.0F, i & 2 ? 4.0F : 0.0F, i & 4 ? 3.0F : 0.0F});
    }
    std::vector<float> vertices;
    std::vector<std::uint32_t> triangles{0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                         2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
};

/// A scene of the C interface; destroyed at the end.
struct CScene {
    CScene() { REQUIRE(aula_scene_create(&handle) == AULA_OK); }
    ~CScene() { aula_scene_destroy(handle); }
    CScene(const CScene&) = delete;
    CScene& operator=(const CScene&) = delete;

    /// Adds the box, of brick, movable.
    void add_box() const {
        const BoxMesh box;
        REQUIRE(aula_scene_add_object(handle, "walls", box.vertices.data(), 8, box.triangles.data(),
                                      12, "brick", 1, nullptr) == AULA_OK);
    }

    aula_scene* handle = nullptr;
};

/// Few rays and short responses; mono.
inline aula_options quick_options(std::int32_t clock) {
    aula_options options{};
    options.size = sizeof(options);
    options.clock = clock;
    options.output = AULA_MONO;
    options.max_sources = 2;
    options.rays = 50;
    options.threads = 1;
    options.ir_length_s = 0.2;
    return options;
}

/// The box with a listener, of the C interface; destroyed at the end.
struct CRoom {
    explicit CRoom(const aula_options& options) {
        const CScene scene;
        scene.add_box();
        REQUIRE(aula_room_create(scene.handle, &options, &handle) == AULA_OK);
        REQUIRE(aula_room_set_listener(handle, 0, &listener, AULA_NOW) == AULA_OK);
    }
    ~CRoom() { aula_room_destroy(handle); }
    CRoom(const CRoom&) = delete;
    CRoom& operator=(const CRoom&) = delete;

    aula_source add_source() const {
        aula_source source = 0;
        REQUIRE(aula_room_add_source(handle, &pose, nullptr, AULA_NOW, &source) == AULA_OK);
        return source;
    }

    aula_pose pose{{1, 1, 1.5F}, 0, 0, 0};
    aula_pose listener{{4, 3, 1.7F}, 3.1F, 0, 0};
    aula_room* handle = nullptr;
};

/// True if the last message of this thread contains a text.
inline bool message_has(const std::string& text) {
    UNSCOPED_INFO("message: " << aula_message());
    return std::string(aula_message()).find(text) != std::string::npos;
}

}  // namespace aula::test
