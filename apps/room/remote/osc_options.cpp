#include "apps/room/remote/osc_options.h"

#include <algorithm>
#include <glm/geometric.hpp>

#include "apps/output/formatted.h"

namespace aula {

namespace {

/// Half of the room's longest side; in free field the distance of the farthest source.
float default_radius_m(const Scene& scene) {
    const Bounds bounds = geometry_bounds(scene.objects);
    if (bounds.diagonal_m() > 0 && !scene.objects.empty()) {
        const Vec3 size = bounds.max - bounds.min;
        return std::max({size.x, size.y, size.z}) / 2;
    }
    float farthest_m = 0;
    for (const Source& source : scene.sources)
        farthest_m = std::max(
            farthest_m, glm::distance(source.position_at(0), scene.listener.pose_at(0).position));
    return farthest_m > 0 ? farthest_m : 1;
}

}  // namespace

AdmRegion::AdmRegion(const Scene& scene, const OscOptions& options)
    : origin(options.adm_origin.value_or(scene.listener.pose_at(0).position)),
      radius_m(options.adm_radius_m ? *options.adm_radius_m : default_radius_m(scene)) {}

std::string AdmRegion::text() const {
    return formatted("ADM-OSC: origin %g, %g, %g m, radius %g m", double{origin.x},
                     double{origin.y}, double{origin.z}, double{radius_m});
}

}  // namespace aula
