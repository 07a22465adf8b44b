#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/direct/edge_paths.h"
#include "engine/direct/reflected_edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// The planes of a scene and the ids of the paths of their first-order image sources.
struct FirstOrderImages {
    const ScenePlanes& planes;
    std::span<const std::uint64_t> ids;  ///< [plane]
    int order = 1;                       ///< highest order of reflections
};

/// Adds diffraction to the first-order image sources of a source and a listener. The group of a
/// plane consists of its image source, if that is audible, of those terms of its faces' edges that
/// belong to the reflection, and of paths that the plane reflects before or after another edge.
/// Their sum is continuous where the reflection point leaves the face and where another object
/// hides the image source. The image source of a face that is small for the wavelength becomes
/// weak. [several threads]
class ReflectionGroups {
 public:
    ReflectionGroups(const RayScene& scene, const SceneEdges& edges, const EdgePaths& paths,
                     double speed_of_sound_m_s);

    /// Replaces first-order image sources in `paths` by the taps of their groups, and adds those
    /// whose image source is not audible. All first-order image sources that are audible are in
    /// `paths`, which are ordered by ascending length. `memory` holds the edges' terms of the
    /// frame; `has_moved`: an object has moved. Energies follow those of the model; see
    /// LevelFollower.
    void complete(std::vector<SoundPath>& paths, const Vec3& source, const Vec3& listener,
                  const FirstOrderImages& images, const OrientedDirectivity& directivity,
                  const Bands& attenuation_per_m, bool has_moved, PairMemory& memory) const;

 private:
    /// The paths over the edges of a plane's faces. Where the reflection passes one of them
    /// closely, its coordinates decide whether the image source is audible, as they decide the sign
    /// of the field.
    struct Group {
        std::vector<EdgePath> paths;  ///< the image source first, if it is audible
        std::optional<bool> is_audible;
        std::uint32_t triangle = 0;  ///< of the face that decides

        void decide(bool audible, std::uint32_t of_triangle) {
            is_audible = is_audible.value_or(true) && audible;
            triangle = of_triangle;
        }
    };

    std::map<std::uint32_t, Group> groups_of(const ScenePlanes& planes, const glm::dvec3& source,
                                             const glm::dvec3& listener,
                                             std::span<const EdgePath> bent) const;
    EdgePath image_path(const ScenePlanes::Plane& plane, const glm::dvec3& source,
                        const glm::dvec3& listener) const;

    const RayScene& scene_;
    const SceneEdges& edges_;
    const EdgePaths& paths_;
    ReflectedEdgePaths reflected_;
    WedgeIntegral integral_;
};

}  // namespace aula
