#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/scene.h"
#include "aula/engine/vec3.h"

namespace aula {

/// The places of all objects, sources and listeners in one frame. A position on a surface is moved
/// off it.
struct FrameInput {
    double time_s = 0;            ///< time on the objects' paths; not used with `objects`
    std::vector<Vec3> sources;    ///< [source] Propagation::source_count() positions
    std::vector<Vec3> listeners;  ///< [listener] as many as Propagation was constructed for
    /// [object] The transform of each object of the scene; ignored for an object that does not
    /// move. If empty, the objects follow their paths.
    std::vector<RigidTransform> objects{};
    /// [source] Rotation from the local axes of each source to the world axes, for its directivity.
    /// If empty, they are parallel.
    std::vector<glm::mat3> source_rotations{};
};

/// The cost of a frame and the size of the caches.
struct FrameStatistics {
    double trace_s = 0;   ///< wall-clock time for tracing rays from the sources
    double cache_s = 0;   ///< wall-clock time for updating the caches
    double gather_s = 0;  ///< wall-clock time of the final gather; 0 for estimators without patches
    double specular_s = 0;                ///< wall-clock time for image sources
    double diffraction_s = 0;             ///< wall-clock time for direct sound with its diffraction
    std::uint64_t segments = 0;           ///< traced ray segments, of emitted and gather rays
    std::uint64_t summed_bins = 0;        ///< time bins of patches that the final gather has added
    std::uint64_t image_reflections = 0;  ///< of examined image sources, of all pairs
    std::size_t cache_entries = 0;        ///< entries of diffuse path caches, or occupied patches
    std::size_t memory_bytes = 0;         ///< memory of the caches
    std::size_t edges = 0;                ///< edges of the scene that diffract sound
    std::size_t bent_paths = 0;           ///< paths over edges from all sources to all listeners
    std::size_t wall_paths = 0;           ///< straight paths through walls, likewise
};

/// The polyline of a ray, for display.
struct PathLine {
    /// Position of the source, then those of the reflections in their order. The line of a ray that
    /// leaves the scene ends at a point in the open.
    std::vector<Vec3> points;
    std::vector<float> energy;  ///< [point] mean of all bands when it leaves, 1 at the source
};

/// An edge that diffracts sound, for display.
struct EdgeLine {
    Vec3 from{0};        ///< one end, world axes, m
    Vec3 to{0};          ///< the other end
    float bend_rad = 0;  ///< angle by which the surface bends at the edge; pi at a free edge
    std::uint32_t triangle = 0;  ///< of one face, counted over all objects in their order
    Vec3 facing{0};              ///< unit normal of that face, towards the open side of the edge
};

/// The place of a patch: the axis-aligned box that contains its surfaces, world axes, m.
struct PatchCell {
    Vec3 low{0};        ///< lowest corner of the box
    Vec3 high{0};       ///< highest corner of the box
    Vec3 direction{0};  ///< dominant direction of the normals, a unit vector along an axis
};

/// The energy that a patch radiates, for display.
struct PatchEnergy {
    PatchCell cell;  ///< where the patch is
    Bands energy;    ///< in 1/m2: per unit emitted energy and area of the patch
};

}  // namespace aula
