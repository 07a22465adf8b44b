#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"

namespace aula {

/// A source as a frame takes it.
struct SourceState {
    std::uint64_t id = 0;  ///< another id is another source
    std::size_t slot = 0;  ///< of the renderer
    std::string name;      ///< of its reverberation's noise: sources of one name sound alike
    Vec3 position{0};
    float gain_db = 0;
    bool heard = true;
    bool ringing =
        false;  ///< it was removed: its last responses are kept, its paths are not traced
    std::int64_t rung_out_at = 0;  ///< the sample time; of those that ring
};

/// What a frame is made for.
struct RoomState {
    double time_s = 0;
    std::vector<SourceState> sources;
    std::vector<Pose> listeners;
    std::vector<RigidTransform> objects{};  ///< one for each, or empty: on their paths at the time
    float direct_gain = 1;                  ///< of the direct sound
    float early_gain = 1;                   ///< of image sources
    float late_gain = 1;                    ///< of everything else
    std::optional<int> rays{};              ///< per source and frame; the scene's where absent
    std::optional<double> frame_share{};    ///< of its time that a frame may take: as many rays
};

/// The scene's sources and listener at a time, each source in the slot of its index, with its index
/// + 1 as its id.
RoomState room_state(const Scene& scene, double time_s);

}  // namespace aula
