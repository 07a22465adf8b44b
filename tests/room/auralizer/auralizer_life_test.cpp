#include <malloc.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "aula/auralizer.h"
#include "aula/exception.h"
#include "tests/room/auralizer/auralizer_rendering.h"
#include "tests/support/wait.h"

using namespace aula;
using namespace aula::test;

namespace {

std::size_t allocated_bytes() {
    const auto info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

/// Renders at the pace of a device.
void play(Auralizer& auralizer, double duration_s) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    constexpr double kBlock_s = 256 / kRate_hz;
    for (int block = 0; block * kBlock_s < duration_s; ++block) {
        std::this_thread::sleep_until(start + std::chrono::duration_cast<Clock::duration>(
                                                  std::chrono::duration<double>(block * kBlock_s)));
        rendered(auralizer, 256, {256}, noise_at);
    }
}

}  // namespace

TEST_CASE("The time of frames stops in a pause") {
    std::mutex mutex;
    std::vector<double> times_s;
    AuralizerOptions options = mono(RenderClock::real_time);
    options.before_frame = [&](Auralizer&, double time_s) {
        const std::lock_guard lock(mutex);
        times_s.push_back(time_s);
    };
    const auto frames = [&] {
        const std::lock_guard lock(mutex);
        return times_s.size();
    };
    Auralizer auralizer(room_with_panel(), options);
    play(auralizer, 0.5);
    auralizer.pause();
    REQUIRE(eventually([&] {
        rendered(auralizer, 256, {256}, noise_at);
        return auralizer.status().paused;
    }));
    const std::size_t before = frames();
    play(auralizer, 1);
    // One can be under way when the sound stops.
    CHECK(frames() <= before + 1);
    auralizer.resume();
    play(auralizer, 0.5);
    REQUIRE(frames() > before + 3);
    for (std::size_t f = 1; f < times_s.size(); ++f) CHECK(times_s[f] > times_s[f - 1]);
    CHECK(times_s[before + 2] - times_s[before - 1] < 0.5);
}

TEST_CASE("After a failure of the propagation commands take no memory") {
    AuralizerOptions options = mono(RenderClock::real_time);
    options.before_frame = [](Auralizer&, double time_s) {
        if (time_s > 0) throw Failure("before_frame failed");
    };
    Scene scene = room_with_panel();
    scene.sources = small_room().sources;
    Auralizer auralizer(scene, options);
    const SourceId source = auralizer.sources()[0];
    const auto failed = [&] {
        try {
            auralizer.status();
            return false;
        } catch (const Failure&) {
            return true;
        }
    };
    REQUIRE(eventually(failed));
    const std::size_t before = allocated_bytes();
    for (int n = 0; n < 20000; ++n) {
        auralizer.set_listener(at(1, 1, 1));
        auralizer.set_source(source, at(2, 1, 1));
        auralizer.set_material(0, Material{});
        auralizer.remove_source(auralizer.add_source({}));
    }
    CHECK(allocated_bytes() < before + 100'000);
    CHECK(auralizer.add_source({}) == SourceId{});
}

TEST_CASE("Twenty thousand sources that come and go take no memory") {
    const RenderClock clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    AuralizerOptions options = mono(clock);
    options.max_sources = 4;
    Auralizer auralizer(room_with_panel(), options);
    SourceId last;
    // The least memory in use: the buffers of frames and responses under way come and go, up to
    // 1 MB of them on a busy machine.
    const auto come_and_go = [&] {
        const std::uint64_t frames = auralizer.status().frames;
        std::size_t least = allocated_bytes();
        for (int n = 0; n < 5000 || auralizer.status().frames < frames + 60; ++n) {
            const SourceId source = auralizer.add_source({.position = {1, 1, 1}});
            auralizer.remove_source(last);
            last = source;
            rendered(auralizer, 16, {16}, noise_at);
            if (n % 10 == 0) least = std::min(least, allocated_bytes());
        }
        return least;
    };
    come_and_go();  // until all frames that can be in use are allocated
    const std::size_t before = come_and_go();
    for (int round = 1; round < 4; ++round) come_and_go();
    CHECK(come_and_go() < before + 2'000'000);  // 100 bytes a source
    CHECK(auralizer.sources().size() == 1);
}

TEST_CASE("Materials that change in a pause take no memory") {
    Auralizer auralizer(room_with_panel(), mono(RenderClock::real_time));
    auralizer.pause();
    REQUIRE(eventually([&] {
        rendered(auralizer, 256, {256}, noise_at);
        return auralizer.status().paused;
    }));
    const auto change = [&] {
        for (int n = 0; n < 5000; ++n) auralizer.set_material(0, Material{});
        // Longer than a frame.
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
    };
    change();
    const std::size_t before = allocated_bytes();
    change();
    CHECK(allocated_bytes() < before + 100'000);
}

TEST_CASE("An HRTF file that cannot be read is refused, and no thread remains") {
    const auto threads = [] {
        const std::filesystem::directory_iterator tasks("/proc/self/task");
        return std::distance(begin(tasks), end(tasks));
    };
    const auto before = threads();
    AuralizerOptions options;
    options.clock = GENERATE(RenderClock::exact, RenderClock::real_time);
    options.hrtf = GENERATE("/nonexistent.sofa", "/proc/self/status");
    CHECK_THROWS_AS(Auralizer(room_with_panel(), options), InputError);
    CHECK(threads() == before);
}
