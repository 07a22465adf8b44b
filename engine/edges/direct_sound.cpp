#include "engine/edges/direct_sound.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace aula {

DirectSound::DirectSound(const RayScene& scene, float speed_of_sound_m_s)
    : scene_(scene), edges_(scene), paths_(scene, edges_, double{speed_of_sound_m_s}) {
    std::map<std::uint32_t, MovableObject> movable;
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        if (scene.moves(triangle)) movable[triangle.object].triangles.push_back(t);
    }
    for (auto& [_, object] : movable) {
        follow(object);
        movable_.push_back(std::move(object));
    }
}

void DirectSound::begin_frame(bool moved) {
    changed_.clear();
    if (!moved) return;
    edges_.scene_moved();
    for (MovableObject& object : movable_) {
        if (object.corners == scene_.triangle(object.triangles[0]).vertices) continue;
        Bounds swept = object.bounds;
        follow(object);
        swept.add(object.bounds.min);
        swept.add(object.bounds.max);
        changed_.push_back(swept);
    }
}

void DirectSound::follow(MovableObject& object) {
    object.corners = scene_.triangle(object.triangles[0]).vertices;
    object.bounds = {};
    for (const std::uint32_t t : object.triangles) object.bounds.add(scene_.triangle(t).vertices);
}

std::vector<SpecularPath> DirectSound::find(const Vec3& source, const Vec3& listener,
                                            const OrientedDirectivity& directivity,
                                            const Bands& attenuation_per_m,
                                            PairMemory& memory) const {
    std::vector<EdgePath> paths =
        paths_.find(source, listener, attenuation_per_m, memory, changed_);
    if (paths.size() == 1 && paths[0].edges.empty()) return {};
    if (!directivity.is_omnidirectional()) {
        for (EdgePath& path : paths) {
            const Bands factor = directivity.factor(path.departure);
            for (std::size_t b = 0; b < kBandCount; ++b)
                path.field[b] *= std::sqrt(double{factor[b]});
        }
    }
    std::vector<SpecularPath> taps = paths_.taps(paths, memory);
    std::stable_sort(taps.begin(), taps.end(), [](const SpecularPath& a, const SpecularPath& b) {
        return a.length_m < b.length_m;
    });
    return taps;
}

}  // namespace aula
