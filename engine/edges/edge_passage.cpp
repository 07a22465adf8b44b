#include "engine/edges/edge_passage.h"

#include <algorithm>
#include <array>

namespace aula {

namespace {

/// Of the points from the faces, which rays along a face would touch: 14 degrees, a height of
/// 0.12 mm at the radius, more than rays are shortened by.
constexpr double kOffFaces_rad = 0.25;
static_assert(EdgePassage::kRadius_m * 0.24 > double{tolerances::kOffset_m});  // its sine: 0.247

/// Of the free width, relative to kNarrow_m: 0.03 dB. Bisections: 8 times the rays of a free edge.
constexpr double kExactWidth = 1.0 / 256;

}  // namespace

EdgePassage::EdgePassage(const DiffractionEdge& edge, double along_m, double from_rad,
                         double to_rad)
    : edge_(edge) {
    // Away from the ends, where the faces of neighbouring edges may hide the point.
    const double margin_m = std::min(kFromEnd_m, edge.length_m / 4);
    apex_ = edge.point(std::clamp(along_m, margin_m, edge.length_m - margin_m));
    const auto off_faces = [&](double angle_rad) {
        return std::clamp(angle_rad, kOffFaces_rad, edge.open_angle_rad - kOffFaces_rad);
    };
    from_rad_ = off_faces(from_rad);
    to_rad_ = off_faces(to_rad);
}

Vec3 EdgePassage::point(double share, double radius_m) const {
    return Vec3(apex_ + radius_m * edge_.direction(from_rad_ + share * (to_rad_ - from_rad_)));
}

bool EdgePassage::is_free(const RayScene& scene, double radius_m) const {
    // Points that are not symmetric: a face through one of them might not be met. The rays are not
    // shortened: at this radius a face may lie within 0.1 mm of a point.
    constexpr std::array kShares{0.0, 0.37, 0.69, 1.0};
    for (std::size_t i = 1; i < kShares.size(); ++i) {
        if (!scene.visible(point(kShares[i - 1], radius_m), point(kShares[i], radius_m), 0)) {
            return false;
        }
    }
    return true;
}

double EdgePassage::opening(const RayScene& scene, double most_m) const {
    if (!is_free(scene)) return 0;
    double free_m = std::min(kNarrow_m, most_m);
    if (free_m <= kRadius_m || is_free(scene, free_m)) return 1;
    double low_m = kRadius_m;
    while (free_m - low_m > kNarrow_m * kExactWidth) {
        const double middle_m = 0.5 * (low_m + free_m);
        (is_free(scene, middle_m) ? low_m : free_m) = middle_m;
    }
    return low_m / kNarrow_m;
}

}  // namespace aula
