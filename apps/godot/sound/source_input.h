#pragma once

#include <aula.h>

#include <array>

#include "apps/godot/sound/bus_processor.h"

namespace aula::godot {

/// Takes the sound of a source from the bus into which its player plays. The bus passes silence on.
class SourceInput final : public BusProcessor {
 public:
    /// Longest block. The engine's has 512 samples.
    static constexpr int kMostSamples = 4096;

    bool processes_silence() const noexcept override { return false; }
    void process(const StereoSample* from, StereoSample* to, int count) noexcept override;

    /// The signal of the present block, silent unless process() was called for it. Each block is
    /// taken once. [audio thread, wait-free]
    aula_signal take(int count) noexcept;

    /// The source in the present room; 0: none. [main thread, no process() at the same time]
    aula_source number = 0;

 private:
    int taken_ = 0;  ///< samples of the present block
    std::array<float, kMostSamples> samples_{};
};

}  // namespace aula::godot
