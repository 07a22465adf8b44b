#include "engine/patches/cell_clipping.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace aula {

float ClippedPolygon::area_m2() const {
    Vec3 sum(0);
    for (int i = 2; i < count_; ++i) sum += glm::cross(at(i - 1) - at(0), at(i) - at(0));
    return glm::length(sum) / 2;
}

Vec3 ClippedPolygon::point(std::array<float, 2> u) const {
    // Selects a triangle of the fan by area, then a point in it.
    const auto area_of = [&](int corner) {
        return glm::length(glm::cross(at(corner - 1) - at(0), at(corner) - at(0))) / 2;
    };
    float rest = u[0] * area_m2();
    int corner = 2;
    while (corner < count_ - 1 && rest >= area_of(corner)) rest -= area_of(corner++);
    const float share = area_of(corner) > 0 ? std::min(1.0F, rest / area_of(corner)) : 0;
    const float across = std::sqrt(share);
    return at(0) + across * ((1 - u[1]) * (at(corner - 1) - at(0)) + u[1] * (at(corner) - at(0)));
}

ClippedPolygon ClippedPolygon::cut(int axis, float at_m, float sign) const {
    ClippedPolygon kept;
    for (int i = 0; i < count_; ++i) {
        const Vec3& a = at(i);
        const Vec3& b = at((i + 1) % count_);
        const float da = sign * (a[axis] - at_m);
        const float db = sign * (b[axis] - at_m);
        if (da <= 0) kept.add(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            kept.add(a + (b - a) * (da / (da - db)));
        }
    }
    return kept;
}

}  // namespace aula
