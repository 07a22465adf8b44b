#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/limits.h"
#include "engine/edges/scene_edges.h"

namespace aula {

/// The edges with the smallest detours between a source and a listener, at most kMax, and what
/// their last tests found. All of them are tested in the first frame and after a jump of an end.
/// Else a frame tests those in use, those near which an object has moved, and an eighth of the
/// others by turns: its cost is that of the edges in use.
class NearEdges {
 public:
    struct Edge {
        std::uint32_t index = 0;  ///< in SceneEdges
        bool is_new = true;       ///< not tested yet
        bool is_free = false;     ///< nothing blocks the path
        double level_db = 0;      ///< above that at which paths are left out

        /// Whether the path over the edge is tested in every frame.
        bool is_in_use() const { return is_free && level_db > -limits::kFade_db; }

        friend bool operator==(const Edge&, const Edge&) = default;
    };

    /// Begins a frame. `changed`: the volumes in which objects have moved since the last one.
    /// `followed`: ascending edges that every frame tests. Returns the places of the edges to test,
    /// ascending.
    std::vector<std::size_t> begin_frame(const SceneEdges& edges, const glm::dvec3& source,
                                         const glm::dvec3& listener,
                                         std::span<const Bounds> changed,
                                         std::span<const std::uint32_t> followed = {});

    /// Counts a frame between equal ends in an equal scene, in which no edge is tested.
    void skip_frame() { ++frames_; }

    /// By ascending index.
    const Edge& operator[](std::size_t place) const { return edges_[place]; }

    /// Sets the result of a test.
    void set(std::size_t place, const Edge& edge) {
        has_changed_ |= !(edges_[place] == edge);
        edges_[place] = edge;
    }

    /// Whether a test of this frame, or a selection, had another result than the last one.
    bool has_changed() const { return has_changed_; }

    /// By ascending index.
    std::span<const Edge> all() const { return edges_; }

    /// A choice: the first frame of a pair tests all of them, with five rays and more each, in
    /// about 3 ms.
    static constexpr std::size_t kMax = 512;

    /// Frames in which all edges are tested once. A choice: an edge that comes into use is heard
    /// after at most 0.27 s at 30 frames per second.
    static constexpr std::uint64_t kTurns = 8;

 private:
    void select(const SceneEdges& edges);
    bool is_near_change(const DiffractionEdge& edge, std::span<const Bounds> changed) const;

    std::vector<Edge> edges_;
    glm::dvec3 source_{0};  ///< in the present frame
    glm::dvec3 listener_{0};
    glm::dvec3 selected_source_{0};  ///< at the last selection
    glm::dvec3 selected_listener_{0};
    std::uint64_t frames_ = 0;  ///< begun so far
    bool has_changed_ = false;
};

}  // namespace aula
