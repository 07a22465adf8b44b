#pragma once

#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/edges/edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The direct sound with its diffraction at the edges of a scene. [propagation thread]
class DirectSound {
 public:
    DirectSound(const RayScene& scene, float speed_of_sound_m_s);

    /// Updates the edges after RayScene::move.
    void scene_moved() { edges_.scene_moved(); }

    const SceneEdges& edges() const { return edges_; }

    /// The paths of a source's direct sound to a listener by ascending length; see SpecularPath.
    /// Empty if no path leads over an edge.
    /// [several threads]
    std::vector<SpecularPath> find(const Vec3& source, const Vec3& listener,
                                   const OrientedDirectivity& directivity,
                                   const Bands& attenuation_per_m) const;

 private:
    SceneEdges edges_;
    EdgePaths paths_;
};

}  // namespace aula
