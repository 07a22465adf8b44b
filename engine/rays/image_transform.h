#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>

#include "engine/base/mix64.h"

namespace aula {

/// The plane of a mirror: dot(normal, x) = offset_m.
struct MirrorPlane {
    glm::dvec3 normal{0};  ///< unit
    double offset_m = 0;
    bool has_images = true;  ///< false: a facet, see SpecularPaths
};

/// The reflections of a purely specular path composed to one isometry T: the image source is at
/// T(source). Where edges of a room split the beam of an image source, the parts meet the same
/// planes in different orders but have the same isometry. Both ends of a path compute the same
/// isometry. The coordinates have their origin within the scene.
struct ImageTransform {
    glm::dmat3 turn{1};
    glm::dvec3 shift_m{0};
    std::uint32_t order = 0;   ///< number of reflections
    bool may_be_image = true;  ///< no plane is a facet

    /// Appends a reflection of a path that is followed from the listener: T M.
    ImageTransform then_from_listener(const MirrorPlane& m) const {
        const glm::dvec3 turned = turn * m.normal;
        return {turn - 2.0 * glm::outerProduct(turned, m.normal), shift_m + 2 * m.offset_m * turned,
                order + 1, may_be_image && m.has_images};
    }

    /// Appends a reflection of a path that is followed from the source: M T.
    ImageTransform then_from_source(const MirrorPlane& m) const {
        return {turn - 2.0 * glm::outerProduct(m.normal, m.normal * turn),
                shift_m - 2 * (glm::dot(m.normal, shift_m) - m.offset_m) * m.normal, order + 1,
                may_be_image && m.has_images};
    }

    /// Identifies order and isometry by the cell that contains the image of an asymmetric point.
    /// Never 0. The planes of a room are rounded: two orders of them move the point by some 0.01
    /// mm, so that one image in a thousand has two keys. Images that are a few centimetres apart
    /// may share a key; as the nearer plane hides the other, at most one of them is audible.
    std::uint64_t key() const {
        constexpr double kCell_m = 0.05;
        const glm::dvec3 p = turn * glm::dvec3(0.6180, 0.4142, 0.7321) + shift_m;
        std::uint64_t key = order;
        for (const double x : {p.x, p.y, p.z}) {
            key = mix64(key ^ static_cast<std::uint64_t>(std::llrint(x / kCell_m)));
        }
        return key != 0 ? key : 1;
    }
};

}  // namespace aula
