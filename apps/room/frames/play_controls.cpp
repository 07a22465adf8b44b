#include "apps/room/frames/play_controls.h"

#include <algorithm>

namespace aula {

bool same_pose(const Pose& a, const Pose& b) {
    return a.position == b.position && a.yaw_rad == b.yaw_rad && a.pitch_rad == b.pitch_rad &&
           a.roll_rad == b.roll_rad;
}

Pose SourceControl::over(Pose pose) const {
    if (position) pose.position = *position;
    if (angles_rad) {
        pose.yaw_rad = angles_rad->x;
        pose.pitch_rad = angles_rad->y;
        pose.roll_rad = angles_rad->z;
    }
    return pose;
}

Pose PlayControls::source_at(const Scene& scene, std::size_t s, double time_s) const {
    const Source& placed = scene.sources[s];
    const SourceControl control = source(s);
    if (!placed.from_listener) return control.over(placed.pose_at(time_s));
    if (control.position) return control.over({});  // no longer on the listener
    return control.over(listener ? listener->at(*placed.from_listener) : placed.pose_at(time_s));
}

bool PlayControls::audible(std::size_t s) const {
    const bool solos = std::any_of(sources.begin(), sources.end(),
                                   [](const SourceControl& source) { return source.solo; });
    return !source(s).muted && (!solos || source(s).solo);
}

}  // namespace aula
