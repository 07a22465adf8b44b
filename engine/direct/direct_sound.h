#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/direct/chain_search.h"
#include "engine/direct/edge_paths.h"
#include "engine/direct/reflection_groups.h"
#include "engine/edges/scene_edges.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The direct sound with its diffraction at the edges of a scene, and through walls. [propagation
/// thread]
class DirectSound {
 public:
    /// `order`: largest number of edges of a path.
    DirectSound(const RayScene& scene, float speed_of_sound_m_s, int order);

    /// Begins a frame; `moved`: RayScene::move has moved objects since the last one.
    void begin_frame(bool moved);

    /// Discards all kept taps after a change of materials. Levels then do not follow the former.
    void materials_changed() {
        ++scene_version_;
        ++materials_;
    }

    /// Searches for chains of edges in the scene of this frame; call before find(). The work of a
    /// frame is limited: see first_pair().
    void search(const Vec3& source, const Vec3& listener, PairMemory& memory) {
        chains_.search(source, listener, memory.chains);
    }

    /// Which of `count` >= 1 pairs this frame searches first: each frame begins with another one.
    std::size_t first_pair(std::size_t count) const {
        return static_cast<std::size_t>(frames_) % count;
    }

    const SceneEdges& edges() const { return edges_; }

    /// The paths of a source's direct sound to a listener by ascending length; see SoundPath.
    /// Empty if no path leads over an edge or through a wall.
    /// `memory` is that of the source and the listener; while nothing has changed in several
    /// frames, its taps are returned. [several threads]
    std::vector<SoundPath> find(const Vec3& source, const Vec3& listener,
                                const OrientedDirectivity& directivity,
                                const Bands& attenuation_per_m, PairMemory& memory) const;

    /// Adds to the first-order image sources in `paths` their diffraction at the edges of their
    /// faces; call after find(). See ReflectionGroups::complete. [several threads]
    void complete_reflections(std::vector<SoundPath>& paths, const Vec3& source,
                              const Vec3& listener, const FirstOrderImages& images,
                              const OrientedDirectivity& directivity,
                              const Bands& attenuation_per_m, PairMemory& memory) const;

 private:
    struct MovableObject {
        std::vector<std::uint32_t> triangles;
        std::array<Vec3, 3> corners{};  ///< of the first triangle in the last frame
        Bounds bounds;                  ///< in the last frame
    };

    std::vector<SoundPath> compute(const Vec3& source, const Vec3& listener,
                                   const OrientedDirectivity& directivity,
                                   const Bands& attenuation_per_m, PairMemory& memory) const;
    void find_changes();
    void follow(MovableObject& object);

    const RayScene& scene_;
    SceneEdges edges_;
    EdgePaths paths_;
    ReflectionGroups reflections_;
    ChainSearch chains_;
    std::uint64_t frames_ = 0;
    std::uint64_t scene_version_ = 0;  ///< changes with movements of objects and with materials
    std::uint64_t materials_ = 0;      ///< number of their changes
    std::vector<MovableObject> movable_;
    std::vector<Bounds> changed_;  ///< volumes in which objects have moved in this frame
};

}  // namespace aula
