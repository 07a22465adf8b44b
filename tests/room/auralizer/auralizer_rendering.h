#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "aula/auralizer.h"
#include "tests/support/test_scenes.h"
#include "tests/support/tone.h"

namespace aula::test {

inline AuralizerOptions mono(RenderClock clock = RenderClock::exact) {
    AuralizerOptions options;
    options.clock = clock;
    options.output = OutputFormat::mono;
    return options;
}

/// The small room without its source, with a movable panel in front of the listener.
inline Scene room_with_panel() {
    Scene scene = small_room();
    scene.simulation.rays = 100;
    scene.simulation.ir_length_s = 0.3F;
    scene.sources.clear();
    Object panel;
    panel.name = "panel";
    panel.vertices = {{0, -1, 0}, {0, 1, 0}, {0, 1, 2}, {0, -1, 2}};
    panel.triangles = {{0, 1, 2}, {0, 2, 3}};
    panel.triangle_materials = {0, 0};
    panel.translation = {2.5F, 2, 0};
    panel.movable = true;
    scene.objects.push_back(panel);
    return scene;
}

inline Pose at(float x, float y, float z, float yaw_rad = 0) {
    Pose pose;
    pose.position = {x, y, z};
    pose.yaw_rad = yaw_rad;
    return pose;
}

/// A swelling tone, then silence.
inline float tone_at(std::int64_t n) {
    static const std::vector<float> tone = test::tone();
    return n >= 0 && n < static_cast<std::int64_t>(tone.size()) ? tone[static_cast<std::size_t>(n)]
                                                                : 0;
}

inline float noise_at(std::int64_t n) {
    auto x = static_cast<std::uint64_t>(n + 1) * 0x9E3779B97F4A7C15ULL;
    x ^= x >> 31;
    x *= 0xBF58476D1CE4E5B9ULL;
    return 0.1F * static_cast<float>(static_cast<double>(x >> 40) * 0x1p-23 - 1);
}

using Signal = std::function<float(std::int64_t)>;

/// Renders with calls of the given sizes, repeated. Sources 1 to 8 and all that are present play
/// the signal, except the `silent` ones. Calls `before(position)` before each call. Returns the
/// channels, one after the other.
inline std::vector<float> rendered(Auralizer& auralizer, std::int64_t length,
                                   const std::vector<int>& sizes, const Signal& signal,
                                   const std::function<void(std::int64_t)>& before = {},
                                   const std::vector<SourceId>& silent = {}) {
    std::vector<std::vector<float>> channels(auralizer.output_channels(),
                                             std::vector<float>(static_cast<std::size_t>(length)));
    std::vector<float> input(4096);
    std::size_t call = 0;
    for (std::int64_t position = 0; position < length;) {
        const int size = static_cast<int>(
            std::min<std::int64_t>(sizes[call++ % sizes.size()], length - position));
        if (before) before(position);
        for (int n = 0; n < size; ++n) input[static_cast<std::size_t>(n)] = signal(position + n);
        std::vector<SourceId> playing = auralizer.sources();
        for (std::uint64_t number = 1; number <= 8; ++number) playing.push_back({number});
        std::vector<SourceSignal> inputs;
        for (const SourceId source : playing)
            if (std::find(silent.begin(), silent.end(), source) == silent.end())
                inputs.push_back({source, input.data()});
        std::vector<float*> outputs;
        for (auto& channel : channels) outputs.push_back(channel.data() + position);
        auralizer.render(inputs, outputs, size);
        position += size;
    }
    std::vector<float> all;
    for (const auto& channel : channels) all.insert(all.end(), channel.begin(), channel.end());
    return all;
}

}  // namespace aula::test
