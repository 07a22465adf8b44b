#include "apps/room/frames/timeline.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace aula {

namespace {

constexpr double kDefaultDuration_s = 10;
/// Additional length for the decay of HRTFs and octave-band filters after the last arrival.
constexpr double kLastFilterTail_s = 0.05;

struct Lengths {
    double paths_s = 0;    ///< the longest unlooped path
    double signals_s = 0;  ///< the longest unlooped signal
    double cycle_s = 0;    ///< the longest loop of either
    bool unlimited_signal = false;
};

Lengths lengths(const TimelineInput& input) {
    Lengths l;
    const auto add_path = [&](const std::optional<Trajectory>& path) {
        if (!path) return;
        double& longest = path->loop ? l.cycle_s : l.paths_s;
        longest = std::max(longest, path->duration_s());
    };
    add_path(input.scene.listener.path);
    for (const Source& source : input.scene.sources) add_path(source.path);
    for (const Object& object : input.scene.objects) add_path(object.path);
    const auto seconds = [&](std::int64_t samples) {
        return static_cast<double>(samples) / input.sample_rate_hz;
    };
    for (const auto& signal : input.signals) {
        if (const auto length = signal->length_samples()) {
            l.signals_s = std::max(l.signals_s, seconds(*length));
        } else {
            l.unlimited_signal = true;
            l.cycle_s = std::max(l.cycle_s, seconds(signal->cycle_samples().value_or(0)));
        }
    }
    return l;
}

Timeline with_tail(const TimelineInput& input, double input_end_s) {
    const Vec3 listener = input.scene.listener.pose_at(input_end_s).position;
    float farthest_m = 0;
    for (const Source& source : input.scene.sources)
        farthest_m = std::max(farthest_m, glm::distance(source.position_at(input_end_s), listener));
    const float direct_s = farthest_m / input.scene.medium.speed_of_sound_m_s();
    const double tail_s =
        Timeline::kFade_s +
        std::max(input.response_length_s, static_cast<double>(direct_s) + kLastFilterTail_s);
    return {.input_end_s = input_end_s, .end_s = input_end_s + tail_s};
}

/// Fades out a block that starts at sample `first`, from a given time on.
void fade_from(double from_s, std::int64_t first, double sample_rate_hz,
               std::span<float> block) noexcept AULA_NONBLOCKING {
    const auto time_of = [&](std::size_t i) {
        return static_cast<double>(first + static_cast<std::int64_t>(i)) / sample_rate_hz;
    };
    if (time_of(block.size()) <= from_s) return;
    if (time_of(0) >= from_s + Timeline::kFade_s) {
        std::fill(block.begin(), block.end(), 0.0F);
        return;
    }
    for (std::size_t i = 0; i < block.size(); ++i) {
        const double faded = std::clamp((time_of(i) - from_s) / Timeline::kFade_s, 0.0, 1.0);
        block[i] *= static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * faded));
    }
}

}  // namespace

void Timeline::fade(std::int64_t first, double sample_rate_hz,
                    std::span<float> block) const noexcept {
    fade_from(input_end_s, first, sample_rate_hz, block);
}

void Timeline::end(std::int64_t first, double sample_rate_hz,
                   std::span<float> block) const noexcept {
    fade_from(end_s - kFade_s, first, sample_rate_hz, block);
}

Timeline offline_timeline(const TimelineInput& input) {
    if (input.duration_s) return {.end_s = *input.duration_s};
    const Lengths l = lengths(input);
    const double finite_s = std::max(l.paths_s, l.signals_s);
    if (finite_s > 0) return with_tail(input, finite_s);
    return {.end_s = l.cycle_s > 0 ? l.cycle_s : kDefaultDuration_s};
}

Timeline live_timeline(const TimelineInput& input) {
    if (input.duration_s) return {.end_s = *input.duration_s};
    const Lengths l = lengths(input);
    if (l.paths_s == 0 && l.unlimited_signal) return {};
    return with_tail(input, std::max(l.paths_s, l.signals_s));
}

}  // namespace aula
