#include "engine/scene/scene_positions.h"

#include <optional>

namespace aula {

namespace {

void append(const Vec3& position, const std::optional<Trajectory>& path,
            std::vector<Vec3>& positions) {
    if (!path) {
        positions.push_back(position);
        return;
    }
    for (const Trajectory::Keyframe& keyframe : path->points)
        positions.push_back(keyframe.pose.position);
}

}  // namespace

std::vector<Vec3> source_positions(const Scene& scene) {
    std::vector<Vec3> positions;
    for (const Source& source : scene.sources) append(source.position, source.path, positions);
    return positions;
}

std::vector<Vec3> listener_positions(const Scene& scene) {
    std::vector<Vec3> positions;
    append(scene.listener.pose.position, scene.listener.path, positions);
    return positions;
}

std::vector<Vec3> scene_positions(const Scene& scene) {
    std::vector<Vec3> positions = source_positions(scene);
    append(scene.listener.pose.position, scene.listener.path, positions);
    return positions;
}

}  // namespace aula
