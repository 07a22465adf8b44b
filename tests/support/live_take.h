#pragma once

#include <functional>
#include <vector>

#include "apps/session/live/live_mixer.h"
#include "apps/session/live/performance.h"

namespace aula::test {

inline constexpr int kTakeBlock = 256;

/// Plays performances through a live mixer as a device would, on one thread: `before(block)` runs
/// ahead of every block and may hand over frames and stages. The first channel.
inline std::vector<float> take(LiveMixer& mixer, int blocks,
                               const std::function<void(int)>& before) {
    std::vector<std::vector<float>> channels(mixer.channels(), std::vector<float>(kTakeBlock));
    std::vector<float*> outputs;
    for (auto& channel : channels) outputs.push_back(channel.data());
    std::vector<float> heard;
    for (int block = 0; block < blocks; ++block) {
        before(block);
        mixer.render(outputs, kTakeBlock);
        heard.insert(heard.end(), channels[0].begin(), channels[0].end());
    }
    return heard;
}

/// Computes a performance's first frame and hands its stage to the mixer.
inline void begin(Performance& performance, LiveMixer& mixer, const PlayControls& controls = {}) {
    auto frame = performance.maker.make_frame();
    performance.maker.fill(mixer.time_s(), controls, *frame);
    performance.frames.publish(std::move(frame));
    mixer.stages().publish(std::move(performance.stage));
}

}  // namespace aula::test
