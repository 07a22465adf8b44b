#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "apps/dataset/plan/manifest.h"
#include "apps/dataset/plan/planned_scene.h"
#include "apps/dataset/plan/room_space.h"

namespace aula {

/// Draws the scenes of a manifest. Keeps a reference to the manifest.
class SceneDrawing {
 public:
    explicit SceneDrawing(const Manifest& manifest);

    /// The scene of an index below Manifest::scenes(), without `first_item`. It depends on the
    /// manifest and the index only. Throws InputError for a bad scene file; a scene without room
    /// for its sources and receivers has an error instead.
    PlannedScene draw(std::uint64_t index);

 private:
    struct FileRoom {
        std::string sha256;
        RoomSpace space;
    };

    RoomSpace draw_box(const BoxRooms& rooms, PlannedScene& scene, RandomStream& random) const;
    const RoomSpace& draw_file(const SceneRooms& rooms, PlannedScene& scene, RandomStream& random);

    const Manifest& manifest_;
    SceneFiles files_;
    std::map<std::pair<const SceneRooms*, std::string>, FileRoom> rooms_;
};

}  // namespace aula
