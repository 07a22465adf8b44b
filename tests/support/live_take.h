#pragma once

#include <functional>
#include <vector>

#include "apps/room/frames/play_controls.h"
#include "apps/room/live/live_mixer.h"
#include "apps/room/live/prepared_scene.h"

namespace aula::test {

inline constexpr int kTakeBlock = 256;

/// Renders blocks of a live mixer on one thread, as a device would. `before(block)` runs before
/// each block and may publish frames and playbacks. Returns the first channel.
inline std::vector<float> take(LiveMixer& mixer, int blocks,
                               const std::function<void(int)>& before) {
    std::vector<std::vector<float>> channels(mixer.channels(), std::vector<float>(kTakeBlock));
    std::vector<float*> outputs;
    for (auto& channel : channels) outputs.push_back(channel.data());
    std::vector<float> output;
    for (int block = 0; block < blocks; ++block) {
        before(block);
        mixer.render(outputs, kTakeBlock);
        output.insert(output.end(), channels[0].begin(), channels[0].end());
    }
    return output;
}

/// Computes a prepared scene's first frame and publishes its playback to the mixer. No frame
/// follows.
inline void begin(PreparedScene& prepared, LiveMixer& mixer, const PlayControls& controls = {}) {
    prepared.apply(controls, mixer.time_s(), true);
    prepared.auralizer.compute_first(mixer.time_s());
    mixer.playbacks().publish(std::move(prepared.playback));
}

}  // namespace aula::test
