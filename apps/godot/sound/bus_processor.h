#pragma once

namespace aula::godot {

/// A sample of both channels, as the engine stores it (AudioFrame).
struct StereoSample {
    float left, right;
};

/// What happens to the sound of one bus of the engine.
class BusProcessor {
 public:
    BusProcessor() = default;
    BusProcessor(const BusProcessor&) = delete;
    BusProcessor& operator=(const BusProcessor&) = delete;
    virtual ~BusProcessor() = default;

    /// Whether a bus without sound is processed, too.
    virtual bool processes_silence() const noexcept = 0;
    /// Processes a block of the bus's first pair of channels. [audio thread, wait-free]
    virtual void process(const StereoSample* from, StereoSample* to, int count) noexcept = 0;
};

}  // namespace aula::godot
