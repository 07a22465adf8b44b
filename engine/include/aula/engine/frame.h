#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/scene.h"
#include "aula/engine/vec3.h"

namespace aula {

/// The positions of all objects, sources and listeners in one frame.
struct FrameInput {
    double time_s = 0;                      ///< of the objects' trajectories, if `objects` is empty
    std::vector<Vec3> sources;              ///< one for each source
    std::vector<Vec3> listeners;            ///< the same number in every frame, at least one
    std::vector<RigidTransform> objects{};  ///< one for each object of the scene, or empty
};

/// The cost of a frame and the size of the caches.
struct FrameStatistics {
    double trace_s = 0;  ///< wall-clock times of parts of the step
    double cache_s = 0;
    double gather_s = 0;
    double specular_s = 0;
    std::uint64_t segments = 0;     ///< traced ray segments, of emitted and gather rays
    std::size_t cache_entries = 0;  ///< diffuse path cache entries, or occupied patches
    std::size_t memory_bytes = 0;   ///< of the caches
};

/// The polyline of a ray, for display.
struct PathLine {
    /// The source, then each reflection; a ray that escapes has a last point in the open.
    std::vector<Vec3> points;
    std::vector<float> energy;  ///< [point] mean of all bands when it leaves, 1 at the source
};

/// The position of a patch's surfaces.
struct PatchCell {
    Vec3 low{0};  ///< of the box that contains the surfaces
    Vec3 high{0};
    Vec3 direction{0};  ///< dominant direction of the normals, a unit vector along an axis
};

/// The energy that a patch radiates, for display.
struct PatchEnergy {
    PatchCell cell;
    Bands energy;  ///< per unit emitted energy and m2 of the patch
};

}  // namespace aula
