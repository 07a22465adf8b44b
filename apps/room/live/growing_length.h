#pragma once

#include <memory>
#include <mutex>
#include <optional>

#include "apps/room/frames/live_load.h"
#include "aula/engine/scene.h"

namespace aula {

/// As long as the room of a scene sounds, in s, rounded as Simulation::ir_length_s; empty if the
/// scene sets a length.
std::optional<double> room_length_s(const Scene& scene);

/// The length of the first live response of a room, in s.
double first_length_s(double room_length_s);

/// The length of the responses of a room that is heard live. It grows from the first length on, and
/// falls to it, by the computation time of the frames (LiveLoad). The owner replaces the room by
/// one of the new length. A length that the scene sets is kept.
class GrowingLength {
 public:
    /// Sets the present length in a scene, which sounds for `room_s` (room_length_s()). A room that
    /// sounds for another time begins with its first length. [building thread]
    void fit(Scene& scene, std::optional<double> room_s);

    /// Counts a room as heard until the result is destroyed, before this object. Nothing is
    /// measured while there are several, whose frames slow down each other. [any thread]
    [[nodiscard]] std::shared_ptr<void> hear();

    /// Adds the computation time of a frame. True if a room of another length is to be built; then
    /// nothing is measured until the next fit(). [propagation thread]
    bool add(double took_s, double period_s);

 private:
    std::mutex mutex_;  ///< of what follows
    std::optional<LiveLoad> load_;
    double length_s_ = 0;   ///< since fit()
    bool changes_ = false;  ///< it is another one after the next fit()
    int rooms_ = 0;
};

}  // namespace aula
