#include "engine/scene/scene_positions.h"

namespace aula {

std::vector<Vec3> scene_positions(const Scene& scene) {
    std::vector<Vec3> positions;
    const auto add = [&](const Vec3& position, const std::optional<Trajectory>& path) {
        if (!path) {
            positions.push_back(position);
            return;
        }
        for (const Trajectory::Keyframe& keyframe : path->points)
            positions.push_back(keyframe.pose.position);
    };
    for (const Source& source : scene.sources) add(source.position, source.path);
    add(scene.listener.pose.position, scene.listener.path);
    return positions;
}

}  // namespace aula
