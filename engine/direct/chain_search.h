#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/edge_chain.h"
#include "engine/direct/edge_paths.h"
#include "engine/edges/scene_edges.h"
#include "engine/edges/wedge_integral.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Finds chains of edges between a source and a listener, by a best-first search over edges that
/// see each other. A search begins when an end has moved by 10 cm, or an object has moved, and goes
/// on in the next frames until it is complete. What it has found so far, and what earlier ones have
/// found, is tried again in each frame. The work of a frame is counted and bounded: equal calls
/// give equal chains. The step that exceeds the bound is completed, and rows are not counted.
/// [propagation thread]
class ChainSearch {
 public:
    /// `order`: largest number of bends, at least 1.
    ChainSearch(const RayScene& scene, const SceneEdges& edges, double speed_of_sound_m_s,
                int order);

    /// Begins a frame, after RayScene::move and SceneEdges::scene_moved. `changed` are volumes in
    /// which objects have moved.
    void begin_frame(std::span<const Bounds> changed);

    /// Begins a search for the chains of a pair, if this is its first one or if its points or the
    /// scene have moved, or continues it, as far as the work of the frame allows.
    void search(const Vec3& source, const Vec3& listener, PairChains& pair);

    /// The paths over the chains of a pair, without those that are far below the `others` between
    /// the same points. [several threads]
    std::vector<EdgePath> find(const Vec3& source, const Vec3& listener, const PairChains& pair,
                               const Bands& attenuation_per_m,
                               std::span<const EdgePath> others) const;

    /// Replaces the paths between two points that lead over some edges of a row by the path over
    /// the row; see EdgeRow. [several threads]
    void join_rows(const Vec3& source, const Vec3& listener, const PairChains& pair,
                   const Bands& attenuation_per_m, std::vector<EdgePath>& paths) const;

    /// Of a pair. A choice, like EdgePaths::kMaxTaps: each takes two wedge integrals and some rays
    /// in every frame.
    static constexpr std::size_t kMaxChains = 8;

 private:
    using Sequence = std::vector<std::uint32_t>;  ///< edges

    /// The edges that an edge sees: the nearest kMaxNeighbours.
    struct Neighbours {
        Sequence edges;
        Bounds reach;                                            ///< of all edges that were tested
        std::vector<std::pair<double, std::uint32_t>> untested;  ///< distance, the nearest last
    };

    /// Work that a search may still do, in tests of whether two edges are near each other.
    struct Budget {
        std::int64_t work;
        bool is_left() const { return work > 0; }
        void ray() { work -= kRay; }
        static constexpr std::int64_t kRay = 64;   ///< as long as a ray
        static constexpr std::int64_t kPath = 64;  ///< or the shortest path over some edges take
    };

    /// The edges that a source or a listener sees, as far as they have been tested.
    struct SeenEdges {
        enum class Result : char { unknown, hidden, visible };
        Vec3 point{0};
        std::vector<Result> results;  ///< [edge]
        std::uint64_t last_use = 0;
    };

    bool begins_anew(const PairChains& pair, const Vec3& source, const Vec3& listener) const;
    void begin(PairChains& pair, Budget& budget);
    bool expand(PairChains& pair, Budget& budget);
    void add(OpenChainSearch& open, const PairChains& pair, Sequence sequence,
             Budget& budget) const;
    void try_chain(std::vector<std::pair<double, Sequence>>& found, const PairChains& pair,
                   Sequence sequence, Budget& budget) const;
    void keep_best(PairChains& pair, Budget& budget) const;
    bool follows_curves(const PairChains& pair, const Vec3& source, const Vec3& listener) const;
    bool is_touched_alone(std::uint32_t edge, const Vec3& source, const Vec3& listener) const;
    std::optional<EdgeChain> chain_of(const Sequence& sequence, const Vec3& source,
                                      const Vec3& listener) const;
    bool is_visible(SeenEdges& seen, std::uint32_t edge, Budget& budget) const;
    SeenEdges& seen_from(const Vec3& point);
    void forget_seen(std::span<const Bounds> changed);
    Sequence near_edges(const Vec3& source, const Vec3& listener) const;
    bool find_neighbours(std::uint32_t edge, Budget& budget);
    Neighbours begin_neighbours(std::uint32_t edge, bool moving, Budget& budget) const;
    void test_neighbours(std::uint32_t edge, Neighbours& neighbours, Budget& budget) const;
    bool see_each_other(const DiffractionEdge& a, const DiffractionEdge& b, Budget& budget) const;

    const RayScene& scene_;
    const SceneEdges& edges_;
    WedgeIntegral integral_;
    std::size_t order_;
    std::vector<char> is_moving_;    ///< [edge]
    std::vector<char> shares_bend_;  ///< [edge] it may form one bend with another one
    bool any_moving_ = false;
    std::map<std::uint32_t, Neighbours> fixed_neighbours_;  ///< both edges are fixed
    std::map<std::uint32_t, Neighbours> moving_neighbours_;
    std::vector<SeenEdges> seen_;
    std::uint64_t seen_uses_ = 0;
    std::uint64_t scene_changes_ = 0;
    Budget budget_{};        ///< of the frame, for pairs that were searched before
    Budget first_budget_{};  ///< of the frame, for the others
};

}  // namespace aula
