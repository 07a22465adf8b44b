#include "aula/audio/realtime.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <future>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "audio/dsp/limiter.h"
#include "audio/render/renderer.h"
#include "audio/spatial/hrtf.h"
#include "tests/audio/convolution/signals.h"
#include "tests/support/realtime_trap.h"

using namespace aula;
using namespace aula::test;

namespace {

/// Prevents the compiler from removing an allocation.
template <typename T>
T* used(T* p) {
    asm volatile("" : : "r"(p) : "memory");
    return p;
}

constexpr double kRate_hz = 48000;

/// A frame of a moving listener, with reflections and with direct sound that disappears and jumps.
SourceSound frame_of_walk(unsigned frame, const Signals& late) {
    SourceSound sound;
    for (std::size_t c = 0; c < 4; ++c) sound.ambisonics[c] = late[c];
    DiscretePath path;
    path.delay_s = 0.01 + 0.0001 * frame + (frame % 50 == 0 ? 0.1 : 0.0);
    path.direction = {std::cos(0.01F * static_cast<float>(frame)),
                      std::sin(0.01F * static_cast<float>(frame)), 0};
    path.band_gain = {1, 1, 1, 0.9F, 0.8F, 0.7F, 0.6F, 0.5F};
    path.id = 1 + frame % 3;
    sound.early = {path};
    path.id = 0;
    sound.early.push_back(path);
    if (frame % 7 != 0) sound.direct = path;
    return sound;
}

}  // namespace

TEST_CASE("The trap detects an allocation and a free") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    RealtimeViolations before;
    RealtimeViolations after;
    {
        const RealtimeTrap trap;
        before = trap.violations();
        std::free(used(std::malloc(100)));
        after = trap.violations();
    }
    CHECK(before.total() == 0);
    CHECK(after.allocations == 1);
    CHECK(after.frees == 1);
    CHECK(after.total() == 2);
}

TEST_CASE("The trap detects every allocation function") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    RealtimeViolations seen;
    void* aligned = nullptr;
    {
        const RealtimeTrap trap;
        void* p = used(std::calloc(3, 5));
        p = used(std::realloc(p, 1000));
        std::free(p);
        delete used(new int(3));
        struct alignas(64) Line {
            char bytes[64];
        };
        delete used(new Line{});
        if (posix_memalign(&aligned, 64, 64) == 0) std::free(used(aligned));
        void* const mapped = mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        munmap(mapped, 4096);
        seen = trap.violations();
    }
    CHECK(seen.allocations == 6);
    CHECK(seen.frees == 5);
}

TEST_CASE("The trap detects a lock and a write") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    std::mutex mutex;
    RealtimeViolations locked;
    RealtimeViolations written;
    {
        const RealtimeTrap trap;
        mutex.lock();
        mutex.unlock();
        locked = trap.violations();
    }
    {
        const RealtimeTrap trap;
        static_cast<void>(!write(STDOUT_FILENO, "", 0));
        written = trap.violations();
    }
    CHECK(locked.locks == 1);
    CHECK(locked.total() == 1);
    CHECK(written.writes == 1);
    CHECK(written.total() == 1);
}

TEST_CASE("The audio thread neither allocates, frees, locks nor writes in 20000 blocks") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    const OutputFormat format =
        GENERATE(OutputFormat::binaural, OutputFormat::mono, OutputFormat::foa);
    constexpr std::size_t kBlock = 64;
    constexpr std::size_t kBlocks = 20000;
    RendererConfig config;
    config.block = kBlock;
    config.response_samples = 2400;
    config.output = format;
    const std::shared_ptr<const Hrtf> hrtf =
        format == OutputFormat::binaural ? std::make_shared<const Hrtf>("", kRate_hz) : nullptr;
    RenderFrameBuilder builder(config, hrtf);
    Renderer renderer(config, hrtf);
    Limiter limiter(kRate_hz, channel_count(format), kBlock);
    const FlushDenormals flush;

    const Signal noise = random_signals(1, kBlock, 1)[0];
    const Signal silence(kBlock);
    const Signals late = random_signals(4, config.response_samples, 2);
    Signals outputs(channel_count(format), Signal(kBlock));
    std::vector<float*> out;
    for (Signal& output : outputs) out.push_back(output.data());

    RealtimeViolations violations;
    unsigned frames = 0;
    float loudest = 0;
    for (std::size_t block = 0; block < kBlocks; ++block) {
        if (block % 25 == 3) {
            std::unique_ptr<RenderFrame> frame = renderer.mailbox().reclaim();
            if (!frame) frame = builder.make_frame();
            const SourceSound sound = frame_of_walk(frames++, late);
            builder.prepare(std::span(&sound, 1), *frame);
            renderer.mailbox().publish(std::move(frame));
        }
        // A third of the blocks are silent, so that all signals decay.
        const std::array<const float*, 1> in{(block / 1000) % 3 == 2 ? silence.data()
                                                                     : noise.data()};
        const auto samples = static_cast<int>(block % 10 == 9 ? 1 + block % kBlock : kBlock);
        const float angle = 0.001F * static_cast<float>(block);
        const HeadRotation head{{{std::cos(angle), std::sin(angle), 0},
                                 {-std::sin(angle), std::cos(angle), 0},
                                 {0, 0, 1}}};
        {
            const RealtimeTrap trap;
            renderer.render(in, head, out, samples);
            limiter.process(out, samples);
            const RealtimeViolations seen = trap.violations();
            violations.allocations += seen.allocations;
            violations.frees += seen.frees;
            violations.locks += seen.locks;
            violations.writes += seen.writes;
        }
        for (const float x : outputs[0]) loudest = std::max(loudest, std::abs(x));
    }
    CHECK(violations.allocations == 0);
    CHECK(violations.frees == 0);
    CHECK(violations.locks == 0);
    CHECK(violations.writes == 0);
    CHECK(frames == 800);
    CHECK(loudest > 0.1F);
}

TEST_CASE("Threads keep the real-time priority inherited from their parent, the parent does not") {
    const int before = sched_getscheduler(0);
    REQUIRE(before != SCHED_FIFO);
    std::thread child;
    int of_child = before;
    std::promise<void> over;
    {
        const RealtimePriority priority;
        if (sched_getscheduler(0) != SCHED_FIFO) {
            WARN("skipped: the system refuses real-time priority");
            return;
        }
        child = std::thread([&] {
            over.get_future().wait();
            of_child = sched_getscheduler(0);
        });
    }
    CHECK(sched_getscheduler(0) == before);
    over.set_value();
    child.join();
    CHECK(of_child == SCHED_FIFO);
}

TEST_CASE("Lowering a thread's priority raises its nice value and that of its children only") {
    if (sched_getscheduler(0) != SCHED_OTHER) {
        WARN("skipped: this thread is not scheduled like others");
        return;
    }
    const auto nice = [] { return getpriority(PRIO_PROCESS, 0); };
    const int before = nice();
    int of_thread = 0;
    int of_child = 0;
    int of_nicer = 0;
    std::thread([&] {
        lower_priority(10);
        of_thread = nice();
        std::thread([&] { of_child = nice(); }).join();
        // A higher nice value is kept.
        lower_priority(15);
        lower_priority(10);
        of_nicer = nice();
    }).join();
    CHECK(of_thread == std::max(before, 10));
    CHECK(of_child == of_thread);
    CHECK(of_nicer == std::max(before, 15));
    CHECK(nice() == before);
}

TEST_CASE("A thread of lowered priority has short time slices if the system supports them") {
    struct {
        std::uint32_t size = 48;
        std::uint32_t policy = 0;
        std::uint64_t flags = 0;
        std::int32_t nice = 0;
        std::uint32_t priority = 0;
        std::uint64_t runtime_ns = 0;
        std::uint64_t deadline_ns = 0;
        std::uint64_t period_ns = 0;
    } usual, short_ones;
    const auto ask = [](auto& attributes) {
        return syscall(SYS_sched_getattr, 0, &attributes, sizeof(attributes), 0U) == 0;
    };
    const bool known = ask(usual);
    std::thread([&] {
        lower_priority(10);
        ask(short_ones);
    }).join();
    if (!known || usual.runtime_ns == 0) {
        WARN("skipped: the system does not report the length of time slices");
        return;
    }
    CHECK(short_ones.runtime_ns == 100'000);
}
