#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "engine/rays/ray_scene.h"

namespace aula {

/// Follows travellers, such as walks or probes, from hit to hit until none is left. In each round
/// one query of the scene finds the ends of all next segments: `segment(traveller)` is a
/// traveller's next ray, and `meet(traveller, ray, hit)` receives its end, changes the traveller
/// and returns false if it ends there. Those that go on keep their order; `end_round()` may add
/// others. PathTracer has a loop of its own, whose paths are lanes of vectors.
template <typename Traveller, typename Segment, typename Meet, typename EndRound>
void follow_rays(const RayScene& scene, std::vector<Traveller>& travellers, const Segment& segment,
                 const Meet& meet, const EndRound& end_round) {
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    while (!travellers.empty()) {
        rays.clear();
        for (const Traveller& traveller : travellers) rays.push_back(segment(traveller));
        hits.resize(rays.size());
        scene.intersect(rays, hits);
        std::size_t alive = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!meet(travellers[i], rays[i], hits[i])) continue;
            if (alive != i) travellers[alive] = std::move(travellers[i]);
            ++alive;
        }
        travellers.erase(travellers.begin() + static_cast<std::ptrdiff_t>(alive), travellers.end());
        end_round();
    }
}

template <typename Traveller, typename Segment, typename Meet>
void follow_rays(const RayScene& scene, std::vector<Traveller>& travellers, const Segment& segment,
                 const Meet& meet) {
    follow_rays(scene, travellers, segment, meet, [] {});
}

}  // namespace aula
