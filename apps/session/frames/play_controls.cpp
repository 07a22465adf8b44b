#include "apps/session/frames/play_controls.h"

#include <algorithm>

namespace aula {

bool same_pose(const Pose& a, const Pose& b) {
    return a.position == b.position && a.yaw_rad == b.yaw_rad && a.pitch_rad == b.pitch_rad &&
           a.roll_rad == b.roll_rad;
}

bool PlayControls::heard(std::size_t s) const {
    const bool solos = std::any_of(sources.begin(), sources.end(),
                                   [](const SourceControl& source) { return source.solo; });
    return !source(s).muted && (!solos || source(s).solo);
}

RoomState PlayControls::applied_to(const Scene& scene, double time_s) const {
    RoomState room = room_state(scene, time_s);
    for (std::size_t s = 0; s < room.sources.size(); ++s) {
        const SourceControl control = source(s);
        SourceState& state = room.sources[s];
        state.position = control.position.value_or(state.position);
        state.gain_db = control.gain_db.value_or(state.gain_db);
        state.heard = heard(s);
    }
    room.listeners[0] = listener_at(scene, time_s);
    room.direct_gain = dry_gain();
    room.early_gain = early ? wet_gain() : 0;
    room.late_gain = late ? wet_gain() : 0;
    room.rays = rays;
    room.frame_share = frame_share;
    return room;
}

}  // namespace aula
