#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/direct/level_follower.h"
#include "engine/direct/near_edges.h"
#include "engine/direct/pair_chains.h"
#include "engine/edges/edge_field.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/oriented_directivity.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// The straight path from a source to a listener, or a path over edges, with the complex pressure
/// that it brings from a source of amplitude 1 at 1 m.
struct EdgePath {
    /// From the source to the listener, indices in SceneEdges. Empty: the straight path.
    std::vector<std::uint32_t> edges;
    unsigned reflections = 0;  ///< at one plane; bit 0: before the edge, bit 1: after it
    std::vector<Vec3> apexes;  ///< where it bends or is reflected, from the source to the listener
    bool is_plain = true;      ///< of a straight path: nothing changes its field, as in free field
    double length_m = 0;
    Vec3 direction{0};  ///< from the listener to the source or to the last edge (near_direction)
    Vec3 departure{0};  ///< from the source to the first edge or to the listener (near_direction)
    ComplexBands field{};
    /// [face] of a single edge: the part of its field that belongs to the path of the reflection.
    std::array<ComplexBands, 2> reflected{};

    /// Multiplies all fields.
    void scale(double factor);
};

/// The primary tap of the last frame.
struct PrimaryTap {
    std::optional<EdgePath> path;
    std::uint64_t key = 0;  ///< 0 until it jumps
};

/// What is remembered of the taps of coherent paths between frames.
struct TapMemory {
    LevelFollower levels;         ///< of all taps
    std::vector<SoundPath> taps;  ///< in the last frame
    PrimaryTap primary;
};

/// What is remembered of the reflections of a source and a listener between frames.
struct PairReflections {
    std::vector<EdgePath> bent;                   ///< paths over single edges in the present frame
    std::map<std::uint32_t, TapMemory> by_plane;  ///< planes whose reflections edges diffract
    Vec3 source{0};                               ///< in the last frame
    Vec3 listener{0};
    std::vector<std::uint32_t> planes;  ///< near ones, by path length
    glm::dvec3 selected_source{0};      ///< when they were selected
    glm::dvec3 selected_listener{0};
    bool has_planes = false;
    bool is_first = true;  ///< no frame has passed
};

/// What is remembered of a source and a listener between frames.
struct PairMemory : TapMemory {
    /// What the taps depend on.
    struct Inputs {
        Vec3 source{0};
        Vec3 listener{0};
        OrientedDirectivity directivity;
        std::uint64_t scene_version = 0;

        friend bool operator==(const Inputs&, const Inputs&) = default;
    };

    NearEdges near;
    PairChains chains;
    std::optional<Inputs> inputs;    ///< of the last frame
    std::uint64_t equal_frames = 0;  ///< in a row, with equal inputs and results
    std::uint64_t materials = 0;     ///< changes of materials before the last frame
    PairReflections reflections;
};

/// The direct sound and its diffraction at single edges. In the lit zone and in the shadow their
/// sum is continuous. [several threads]
class EdgePaths {
 public:
    EdgePaths(const RayScene& scene, const SceneEdges& edges, double speed_of_sound_m_s);

    /// The straight path, if nothing blocks it, and the paths over single edges whose two segments
    /// nothing blocks. The straight path is first, the others have the order of their edges. The
    /// pressure at the listener is the sum of all fields. `memory` is that of the source and the
    /// listener, `changed` the volumes in which objects have moved since the last frame.
    std::vector<EdgePath> find(const Vec3& source, const Vec3& listener,
                               const Bands& attenuation_per_m, PairMemory& memory,
                               std::span<const Bounds> changed = {}) const;

    /// The mean energies of paths in the octaves, in 1/m2: those of all their taps.
    Bands energy(std::span<const EdgePath> paths) const;

    /// Limits the fields of paths, the straight one first, where their mean energy exceeds those of
    /// free field and of the strongest single edge by more than several paths can. Returns the mean
    /// energies.
    Bands limit(std::span<EdgePath> paths, double straight_m, const Bands& attenuation_per_m) const;

    /// Paths, the straight one first, as taps of the direct sound, whose energies add up: the
    /// primary tap first, the main path of the direct sound. It is the straight path or, in the
    /// shadow, the strong path of the smallest length. The fields of other paths are added to its
    /// field as far as they cohere with it within the bandwidth of an octave; the rest of their
    /// energy has separate taps, at most kMaxTaps - 1, with keys of their edges. The primary tap of
    /// the last frame keeps it from changing to and fro. Where it changes to a distant path it gets
    /// a new key: the sound fades from one path to the other. Empty without a path.
    std::vector<SoundPath> taps(std::span<const EdgePath> paths, PrimaryTap& last) const;

    /// Of a pair. A choice: each is a filter and a direction of the renderer for a source.
    static constexpr std::size_t kMaxTaps = 8;

 private:
    struct Candidate;
    std::optional<Candidate> candidate(std::uint32_t edge, const glm::dvec3& source,
                                       const glm::dvec3& listener) const;
    double opening(const Candidate& candidate, const Vec3& source, const Vec3& listener) const;
    bool are_of_one_screen(const Candidate& a, const Candidate& b) const;
    EdgeField field(const Candidate& candidate, const Bands& attenuation_per_m) const;
    double coherence_argument(const EdgePath& a, const EdgePath& b) const;

    const RayScene& scene_;
    const SceneEdges& edges_;
    WedgeIntegral integral_;
};

}  // namespace aula
