#include "audio/render/frame_phase.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>

using aula::FramePhase;

namespace {

/// Takes frames that are due every `frame` samples at calls of `block` samples, at least `fade`
/// apart. Returns the largest difference of the times from due to the frame's state, after the
/// first frames.
std::int64_t jitter(std::int64_t frame, std::int64_t block, std::int64_t fade) {
    FramePhase phase(static_cast<std::size_t>(frame), static_cast<std::size_t>(block),
                     static_cast<std::size_t>(fade));
    std::int64_t taken_frame = -1;
    std::int64_t begun_at = -fade;
    std::int64_t least = INT64_MAX;
    std::int64_t most = 0;
    for (std::int64_t now = 0; now < 500 * frame; now += block) {
        const std::int64_t newest = now / frame;
        if (newest == taken_frame || now < begun_at) continue;
        if (!phase.is_exact() && now < begun_at + fade) continue;
        const std::int64_t reached = phase.take(now);
        begun_at = std::max(now, begun_at + fade);
        // The state is not reached before the next frame takes effect.
        CHECK(reached >= begun_at + std::min(frame, fade));
        taken_frame = newest;
        if (newest < 10) continue;
        least = std::min(least, reached - newest * frame);
        most = std::max(most, reached - newest * frame);
    }
    return most - least;
}

}  // namespace

TEST_CASE("Each frame's state is reached at a fixed time after the frame is due") {
    for (const std::int64_t frame : {400, 480, 1470, 1600, 4800}) {
        for (const std::int64_t block : {1, 64, 256, 480, 1024, 2048}) {
            CAPTURE(frame, block);
            CHECK(jitter(frame, block, std::max<std::int64_t>(frame, 512)) == 0);
        }
    }
}

TEST_CASE("The phase follows frames that come earlier or later from some time on") {
    FramePhase phase(1600, 256, 1600);
    CHECK(phase.take(256) == 256 + 1856);
    CHECK(phase.take(1856) == 1856 + 1856);
    CHECK(phase.take(3456 + 256) == 3456 + 1856);  // a block late, at most
    CHECK(phase.take(5056 + 512) == 5056 + 2112);  // two blocks late: the others are, from now on
    CHECK(phase.take(6912) == 6912 + 1856);        // earlier
    // Frames are missed.
    CHECK(phase.take(6912 + 3 * 1600 + 100) == 6912 + 3 * 1600 + 1856);
}
