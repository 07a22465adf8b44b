#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Follows paths, such as walks or probes, from hit to hit until none is left. In each round one
/// query of the scene finds the ends of all next segments: `segment(path)` is the next ray of a
/// path; `meet(path, ray, hit)` receives its end, changes the path and returns false if the path
/// ends there. Those that go on keep their order; `end_round()` may add others. PathTracer has a
/// loop of its own, whose paths are lanes of vectors.
template <typename Path, typename Segment, typename Meet, typename EndRound>
void follow_rays(const RayScene& scene, std::vector<Path>& paths, const Segment& segment,
                 const Meet& meet, const EndRound& end_round) {
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    while (!paths.empty()) {
        rays.clear();
        for (const Path& path : paths) rays.push_back(segment(path));
        hits.resize(rays.size());
        scene.intersect(rays, hits);
        std::size_t alive = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!meet(paths[i], rays[i], hits[i])) continue;
            if (alive != i) paths[alive] = std::move(paths[i]);
            ++alive;
        }
        paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(alive), paths.end());
        end_round();
    }
}

template <typename Path, typename Segment, typename Meet>
void follow_rays(const RayScene& scene, std::vector<Path>& paths, const Segment& segment,
                 const Meet& meet) {
    follow_rays(scene, paths, segment, meet, [] {});
}

}  // namespace aula
