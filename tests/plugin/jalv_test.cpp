#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "tests/plugin/host_commands.h"
#include "tests/plugin/watched_calls.h"
#include "tests/support/jack_server.h"

// The plugin in jalv, on a private JACK server. Whether the server is in time depends on what else
// the machine does; the processor time of each call of run() and its waits depend on the plugin
// alone.

using namespace aula::test;
namespace fs = std::filesystem;

namespace {

/// Threads with real-time priority of a process.
int realtime_threads(const std::string& process) {
    int count = 0;
    std::error_code ended;
    for (fs::directory_iterator task(fs::path("/proc") / process / "task", ended), end;
         !ended && task != end; task.increment(ended)) {
        const int policy = sched_getscheduler(std::stoi(task->path().filename().string()));
        if (policy == SCHED_FIFO || policy == SCHED_RR) ++count;
    }
    return count;
}

/// What a run of jalv has given.
struct Take {
    WatchedCalls calls;
    std::vector<float> sound;  ///< two channels, interleaved
    int realtime_threads = 0;  ///< at most
};

/// A folder with the bundle, whose binary is the watched one.
void write_watched_bundle(const fs::path& folder) {
    const fs::path bundle = folder / "aula.lv2";
    fs::create_directory(bundle);
    for (const char* name : {"manifest.ttl", "aula.ttl"})
        fs::copy_file(fs::path(AULA_BUNDLES) / "aula.lv2" / name, bundle / name);
    fs::create_symlink(AULA_WATCHED_PLUGIN, bundle / "aula.so");
}

/// Runs jalv with the lines of a shell script as its input. No calls if no JACK server can run.
Take play(const std::string& script) {
    const JackServer server(256);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return {};
    }
    const TemporaryFolder folder;
    write_watched_bundle(folder.path());
    const std::string home = folder.path();
    const std::string name = "aula-" + std::to_string(getpid());
    Program jalv({"env", "LV2_PATH=" + home + ":/usr/lib/lv2", "HOME=" + home,
                  "XDG_CONFIG_HOME=" + home, "AULA_TEST_TAKE=" + home, "sh", "-c",
                  "cd " + home + " && { until [ -e active ]; do sleep 0.1; done; " + script +
                      " sleep 1; } | jalv -x -n " + name +
                      " -c quality=0 'urn:aula:room#binaural'"});
    Take take;
    while (jalv.running()) {
        const fs::path active = folder.path() / "active";
        if (fs::exists(active))
            take.realtime_threads =
                std::max(take.realtime_threads, realtime_threads(read_file(active)));
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    const ProgramResult result = jalv.wait();
    const std::string calls = read_file(folder.path() / "calls");
    INFO(result.out << result.err);
    REQUIRE(result.status == 0);
    REQUIRE(calls.size() == sizeof take.calls);
    std::memcpy(&take.calls, calls.data(), calls.size());
    const std::string sound = read_file(folder.path() / "sound");
    take.sound.resize(sound.size() / sizeof(float));
    std::memcpy(take.sound.data(), sound.data(), take.sound.size() * sizeof(float));
    return take;
}

}  // namespace

TEST_CASE("In jalv the plugin plays in time while its source moves 20 times a second") {
    if (!has("jalv") || !has("jackd")) return;
    const char* const wanted = std::getenv("AULA_TEST_JALV_SECONDS");
    const int seconds = wanted != nullptr ? std::atoi(wanted) : 10;
    const Take take =
        play("i=0; while [ $i -lt " + std::to_string(20 * seconds) +
             " ]; do echo set source_x $((3 + i % 5)).$((i % 10)); sleep 0.05; i=$((i+1)); done;");
    if (take.calls.count == 0) return;
    // More than half of the blocks, also if the server of a busy machine omits some.
    CHECK(take.calls.count > seconds * 48000 / 256 / 2);
    CHECK(take.calls.moves > 10 * seconds);
    INFO(take.calls.count << " calls of "
                          << 1e3 * take.calls.total_s / static_cast<double>(take.calls.count)
                          << " ms, the longest " << 1e3 * take.calls.longest_s << " ms");
    // A virtual machine that its host stops may count the pause as processor time. The source moves
    // in one call of nine.
    CHECK(take.calls.late <= take.calls.count / 1000);
    CHECK(take.calls.waits == 0);
    // The kernel may move a page.
    CHECK(take.calls.page_faults <= take.calls.count / 200);
    // That of JACK, which calls the plugin.
    CHECK(take.realtime_threads == 1);
    CHECK(std::all_of(take.sound.begin(), take.sound.end(),
                      [](float x) { return std::isfinite(x); }));
    for (std::size_t c = 0; c < 2; ++c) {
        float loudest = 0;
        for (std::size_t n = c; n < take.sound.size(); n += 2)
            loudest = std::max(loudest, std::abs(take.sound[n]));
        CHECK(loudest > 0.01F);
    }
}

TEST_CASE("In jalv bypass has no step above -60 dB") {
    if (!has("jalv") || !has("jackd")) return;
    const Take take =
        play("for i in 1 2 3; do sleep 1; echo set enabled 0; sleep 1; echo set enabled 1; done;");
    if (take.calls.count == 0) return;
    for (std::size_t c = 0; c < 2; ++c) {
        float loudest = 0;
        float step = 0;
        for (std::size_t n = 2 + c; n < take.sound.size(); n += 2) {
            loudest = std::max(loudest, std::abs(take.sound[n]));
            step = std::max(step, std::abs(take.sound[n] - take.sound[n - 2]));
        }
        // Bypassed, the tone itself; its steps come in addition.
        CHECK(loudest >= 0.999F * kTone_amplitude);
        const float own =
            loudest * 2 * std::numbers::pi_v<float> * static_cast<float>(kTone_hz) / 48000;
        CHECK(step < own + 0.001F);
    }
}
