#pragma once

#include <aula.h>

#include <array>
#include <atomic>
#include <utility>
#include <vector>

#include "apps/godot/sound/source_input.h"

namespace aula::godot {

/// Renders a room into a bus, from inputs whose buses the engine has processed in the same step.
///
/// The main thread makes changes while it holds the engine's audio lock, which the engine holds
/// around process().
class RoomOutput final : public BusProcessor {
 public:
    /// Most sources of a room.
    static constexpr std::size_t kMostInputs = 1024;

    explicit RoomOutput(double sample_rate_hz);

    // [main thread, no process() at the same time]
    /// Plays a room from now on; null: silence. `exact`: its clock is AULA_EXACT. Returns the room
    /// before. Neither is owned.
    aula_room* exchange(aula_room* room, bool exact) noexcept;
    /// Adds an input. False if there are kMostInputs.
    bool add(SourceInput& input);
    void remove(SourceInput& input);

    /// Share of real time that process() takes, the mean of about the last second. [any thread]
    float load() const noexcept { return load_.load(std::memory_order_relaxed); }

    bool processes_silence() const noexcept override { return true; }
    void process(const StereoSample* from, StereoSample* to, int count) noexcept override;

 private:
    using Channel = std::array<float, SourceInput::kMostSamples>;

    bool render(StereoSample* to, int count) noexcept;

    aula_room* room_ = nullptr;
    bool exact_ = false;
    std::vector<SourceInput*> inputs_;
    std::vector<aula_signal> signals_;
    Channel left_{}, right_{};
    std::atomic<float> load_{0};
    double sample_rate_hz_;
};

}  // namespace aula::godot
