#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// State of a source in a frame.
struct SourceState {
    std::uint64_t id = 0;  ///< unique for each source
    std::size_t slot = 0;  ///< of the renderer
    std::string name;      ///< seeds its noise carriers
    Pose pose;
    Directivity directivity;
    float gain_db = 0;
    /// Sample time of its removal. Its last responses are kept, its paths are not traced.
    std::optional<std::int64_t> removed_at{};
};

/// State of the room for which a frame is computed.
struct RoomState {
    double time_s = 0;
    std::vector<SourceState> sources;
    std::vector<Pose> listeners;
    std::vector<RigidTransform> objects{};  ///< one each; if empty: on their paths at `time_s`
    float direct_gain = 1;                  ///< of the direct sound
    float early_gain = 1;                   ///< of image sources
    float late_gain = 1;                    ///< of everything else
    std::optional<int> rays{};              ///< per source and frame; the scene's where absent
    std::optional<double> frame_share{};    ///< of the frame period to spend; limits the rays
    /// Counted time that a frame may take (counted_s()), in s; limits the rays.
    std::optional<double> work_s{};
    /// Sample times at which the frame is exchanged and replaced, where they are known.
    std::optional<std::pair<std::int64_t, std::int64_t>> exchange{};
};

/// The scene's sources and listener at a time. Source i has slot i and id i + 1.
RoomState room_state(const Scene& scene, double time_s);

}  // namespace aula
