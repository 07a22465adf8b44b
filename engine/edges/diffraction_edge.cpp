#include "engine/edges/diffraction_edge.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace aula {

glm::dvec3 DiffractionEdge::direction(double angle_rad) const {
    return std::cos(angle_rad) * first_face + std::sin(angle_rad) * glm::cross(axis, first_face);
}

WedgePoint DiffractionEdge::coordinates(const glm::dvec3& point) const {
    const glm::dvec3 offset = point - start;
    const double x = glm::dot(offset, first_face);
    const double y = glm::dot(offset, glm::cross(axis, first_face));
    double angle_rad = std::atan2(y, x);
    if (angle_rad < 0) angle_rad += 2 * std::numbers::pi;
    return {std::hypot(x, y), angle_rad, glm::dot(offset, axis)};
}

WedgePoint DiffractionEdge::coordinates(const glm::dvec3& point, double side) const {
    using tolerances::kInPlane_m;
    WedgePoint at = coordinates(point);
    const double height_m = at.radius_m * std::sin(at.angle_rad);
    if (!is_free() || std::abs(height_m) >= kInPlane_m || at.radius_m < tolerances::kSame_m)
        return at;
    const glm::dvec3 normal = glm::cross(axis, first_face);
    int largest = 0;
    for (int i = 1; i < 3; ++i) {
        if (std::abs(normal[i]) > std::abs(normal[largest]) + 1e-3) largest = i;
    }
    at.angle_rad = std::atan2(normal[largest] > 0 ? side * kInPlane_m : -side * kInPlane_m,
                              at.radius_m * std::cos(at.angle_rad));
    if (at.angle_rad < 0) at.angle_rad += 2 * std::numbers::pi;
    return at;
}

double DiffractionEdge::open_angle_of(const glm::dvec3& point) const {
    return open_angle_of(coordinates(point));
}

double DiffractionEdge::open_angle_of(const WedgePoint& point) const {
    const double angle_rad = point.angle_rad;
    if (angle_rad <= open_angle_rad) return angle_rad;
    return angle_rad - open_angle_rad < 2 * std::numbers::pi - angle_rad ? open_angle_rad : 0;
}

bool DiffractionEdge::is_nearest(const WedgePoint& source, const WedgePoint& listener) const {
    constexpr double kRight_rad = std::numbers::pi / 2;
    const double x_m = listener.radius_m * std::cos(listener.angle_rad) -
                       source.radius_m * std::cos(source.angle_rad);
    const double y_m = listener.radius_m * std::sin(listener.angle_rad) -
                       source.radius_m * std::sin(source.angle_rad);
    // Of the two normals of the straight line, the one towards the middle of the directions.
    const double middle_rad = 0.5 * (source.angle_rad + listener.angle_rad);
    const double normal_rad =
        middle_rad + std::remainder(std::atan2(y_m, x_m) + kRight_rad - middle_rad, 2 * kRight_rad);
    return std::min(normal_rad, open_angle_rad - normal_rad) >= kRight_rad;
}

bool DiffractionEdge::is_across_narrow_face(const DiffractionEdge& other) const {
    const glm::dvec3 middle = point(length_m / 2);
    const glm::dvec3 other_middle = other.point(other.length_m / 2);
    const WedgePoint here = beside(other_middle);
    const WedgePoint there = other.beside(middle);
    const auto is_within = [](const DiffractionEdge& edge, const WedgePoint& at) {
        return at.along_m > 0 && at.along_m < edge.length_m;
    };
    return !is_curved && !other.is_curved && is_along(other) &&
           std::max(here.radius_m, there.radius_m) < kNarrow_m &&
           (is_within(*this, here) || is_within(other, there)) &&
           is_on_face(coordinates(other_middle).angle_rad) &&
           other.is_on_face(other.coordinates(middle).angle_rad);
}

bool DiffractionEdge::is_in_screen(const glm::dvec3& point) const {
    const double angle_rad = coordinates(point).angle_rad;
    return is_free() &&
           std::min(angle_rad, 2 * std::numbers::pi - angle_rad) < tolerances::kOnFace_rad;
}

}  // namespace aula
