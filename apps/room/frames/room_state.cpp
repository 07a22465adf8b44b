#include "apps/room/frames/room_state.h"

namespace aula {

RoomState room_state(const Scene& scene, double time_s) {
    RoomState room;
    room.time_s = time_s;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        const Source& source = scene.sources[s];
        room.sources.push_back({.id = s + 1,
                                .slot = s,
                                .name = source.name,
                                .pose = source.pose_at(time_s),
                                .directivity = source.directivity,
                                .gain_db = source.gain_db});
    }
    room.listeners = {scene.listener.pose_at(time_s)};
    return room;
}

}  // namespace aula
