#include <alsa/asoundlib.h>
#include <dlfcn.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>
#include <thread>

#include "aula/audio/sound_file.h"
#include "aula/devices/device.h"
#include "aula/devices/microphone.h"
#include "aula/exception.h"
#include "tests/support/pulse_server.h"
#include "tests/support/wait.h"

namespace pulse_test {

using namespace aula;
using namespace aula::test;

// These tests play in real time on a separate server through ALSA's plugin, as on a desktop. They
// check flags and recordings.

namespace {

constexpr double kRate_hz = 48000;
constexpr int kBlock = 256;

/// Number of calls of snd_pcm_prepare() until one fails, as if the server died in that moment. A
/// stream is prepared when it is opened and when it is started.
std::atomic<int> until_failure = 0;

int realtime_threads() {
    int count = 0;
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
        count += sched_getscheduler(std::stoi(thread.path().filename())) == SCHED_FIFO;
    return count;
}

/// PulseAudio's device, or a warning if no server can run here.
std::optional<DeviceInfo> pulse_device(const PulseServer& server) {
    if (!server.running()) {
        WARN("skipped: no PulseAudio server can run here");
        return {};
    }
    for (const DeviceInfo& device : list_output_devices()) {
        if (device.name == "pulse") return device;
    }
    WARN("skipped: ALSA knows no PulseAudio here (libasound2-plugins)");
    return {};
}

}  // namespace

/// Replaces ALSA's function, which PortAudio calls when a stream starts.
extern "C" int snd_pcm_prepare(snd_pcm_t* pcm) {
    static const auto real =
        reinterpret_cast<decltype(&snd_pcm_prepare)>(dlsym(RTLD_NEXT, "snd_pcm_prepare"));
    return until_failure > 0 && --until_failure == 0 ? -ENODEV : real(pcm);
}

TEST_CASE("A device that hangs when started is abandoned and can be opened again") {
    PulseServer server;
    if (!pulse_device(server)) return;
    std::atomic<int> calls = 0;
    const auto count = [&](std::span<float* const>, int) { ++calls; };
    {
        AudioDevice device("pulse", kRate_hz, 2, kBlock, count);
        until_failure = 1;
        CHECK_THROWS_WITH(device.start(), Catch::Contains("does not answer"));
    }
    CHECK(calls == 0);
    AudioDevice device("pulse", kRate_hz, 2, kBlock, count);
    device.start();
    CHECK(eventually([&] { return calls > 100; }));

    server.kill();
    CHECK(eventually([&] { return device.state() == DeviceState::lost; }));
    until_failure = 2;
    server.restart();
    REQUIRE(server.running());
    CHECK(eventually([] { return until_failure == 0; }));
    CHECK(eventually([&] { return device.state() == DeviceState::playing; }));
    calls = 0;
    CHECK(eventually([&] { return calls > 100; }));
    device.stop();
}

TEST_CASE(
    "A tone is played by a PulseAudio sink, and again when the server returns after a crash") {
    PulseServer server;
    if (!pulse_device(server)) return;
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "recorded.wav";
    const int others = realtime_threads();
    std::atomic<int> calls = 0;
    AudioDevice device("pulse", kRate_hz, 2, kBlock,
                       [&, time = 0](std::span<float* const> outputs, int samples) mutable {
                           for (int n = 0; n < samples; ++n, ++time) {
                               const double phase = 2 * std::numbers::pi * (time % 48) / 48;
                               for (float* const output : outputs) {
                                   output[n] = static_cast<float>(0.5 * std::sin(phase));
                               }
                           }
                           ++calls;
                       });
    {
        const auto recording = server.record(file);
        device.start();
        REQUIRE(eventually([&] { return calls > 750; }));  // four seconds
        // One thread of PortAudio, one of PulseAudio.
        if (device.meter().realtime()) CHECK(realtime_threads() == others + 2);
    }
    // The time in which a virtual machine stands still counts as computing.
    CHECK(device.meter().rendering_underruns() < 10);
    const std::vector<float> recorded = read_sound(file, kRate_hz).samples;
    const auto loud =
        std::count_if(recorded.begin(), recorded.end(), [](float x) { return std::abs(x) > 0.4F; });
    // 41 % of the samples of a sine exceed 0.8 of its peak. At least two seconds were recorded.
    CHECK(loud > std::lround(0.4 * 2 * kRate_hz));
    CHECK(*std::max_element(recorded.begin(), recorded.end()) == Approx(0.5).margin(1e-3));

    server.kill();
    CHECK(eventually([&] { return device.state() == DeviceState::lost; }));
    server.restart();
    REQUIRE(server.running());
    CHECK(eventually([&] { return device.state() == DeviceState::playing; }));
    calls = 0;
    CHECK(eventually([&] { return calls > 100; }));
    device.stop();
}

TEST_CASE("A gap that the sound system reports is counted as an underrun") {
    PulseServer server;
    // The plugin reports underruns only if it is configured to. The server's home is its folder.
    std::ofstream(std::filesystem::path(std::getenv("HOME")) / ".asoundrc")
        << "pcm.!pulse { type pulse handle_underrun 1 }\n";
    snd_config_update_free_global();
    if (!pulse_device(server)) return;
    constexpr int kGapCall = 100;
    std::atomic<int> calls = 0;
    std::atomic<std::uint64_t> before = 0;  ///< underruns before the gap
    AudioDevice device("pulse", kRate_hz, 2, kBlock,
                       [&](std::span<float* const> outputs, int samples) {
                           for (float* const output : outputs) std::fill_n(output, samples, 0.5F);
                           // Longer than the buffers, shorter than the silence of a lost device.
                           if (++calls == kGapCall) {
                               before = device.meter().underruns();
                               std::this_thread::sleep_for(std::chrono::milliseconds(600));
                           }
                       });
    device.start();
    CHECK(eventually([&] { return calls > kGapCall && device.meter().underruns() > before; }));
    CHECK(before < kGapCall / 2);  // without a gap there is none, but on a busy machine
    device.stop();
    snd_config_update_free_global();
}

TEST_CASE("A sink that was idle begins to play late, and is not lost") {
    PulseServer server(true);
    if (!pulse_device(server)) return;
    for (int start = 0; start < 4; ++start) {
        std::atomic<int> calls = 0;
        AudioDevice device("pulse", kRate_hz, 2, kBlock,
                           [&](std::span<float* const> outputs, int samples) {
                               for (float* const channel : outputs)
                                   std::fill_n(channel, samples, 0.0F);
                               ++calls;
                           });
        device.start();
        CHECK(eventually([&] { return calls > 100; }));
        CHECK(device.reconnects() == 0);
        device.stop();
    }
}

TEST_CASE("A microphone records its input") {
    PulseServer server;
    const auto pulse = pulse_device(server);
    if (!pulse) return;
    // The default input is the monitor of the sink: it records the tone that is played.
    Microphone microphone(*pulse, kRate_hz, kBlock);
    CHECK(microphone.name() == "pulse");
    std::atomic<int> calls = 0;
    std::atomic<int> loud = 0;
    std::atomic<int> different = 0;
    AudioDevice device(
        "pulse", kRate_hz, 1, kBlock,
        [&, time = 0, recorded = std::vector<float>(kBlock), again = std::vector<float>(kBlock)](
            std::span<float* const> outputs, int samples) mutable {
            const auto count = static_cast<std::size_t>(samples);
            microphone.read(time, std::span(recorded).first(count));
            microphone.read(time, std::span(again).first(count));
            if (recorded != again) ++different;
            for (int n = 0; n < samples; ++n, ++time) {
                const double phase = 2 * std::numbers::pi * (time % 48) / 48;
                outputs[0][n] = static_cast<float>(0.5 * std::sin(phase));
                if (std::abs(recorded[static_cast<std::size_t>(n)]) > 0.4F) ++loud;
            }
            ++calls;
        });
    device.start();
    REQUIRE(eventually([&] { return calls > 1000; }));  // five seconds
    device.stop();
    CHECK(different == 0);
    // 41 % of the samples of a sine exceed 0.8 of its peak. At least two seconds were recorded.
    CHECK(loud > std::lround(0.4 * 2 * kRate_hz));
    CHECK(microphone.alive());
}

TEST_CASE("A microphone leaves no descriptor open, while a device plays") {
    PulseServer server;
    const auto pulse = pulse_device(server);
    if (!pulse) return;
    std::atomic<int> calls = 0;
    AudioDevice device("pulse", kRate_hz, 1, kBlock,
                       [&](std::span<float* const> outputs, int samples) {
                           std::fill_n(outputs[0], samples, 0.0F);
                           ++calls;
                       });
    device.start();
    REQUIRE(eventually([&] { return calls > 0; }));
    const auto open_descriptors = [] {
        return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
    };
    const auto before = open_descriptors();
    {
        const Microphone microphone(*pulse, kRate_hz, kBlock);
        CHECK(open_descriptors() > before);
    }
    CHECK(open_descriptors() == before);
    device.stop();
}

TEST_CASE("A microphone is refused if there is no input") {
    setenv("JACK_DEFAULT_SERVER", "aula-test-no-such-server", 1);
    DeviceInfo jack;
    jack.host_api = "JACK";
    CHECK_THROWS_WITH(Microphone(jack, kRate_hz, kBlock), Catch::StartsWith("no microphone: "));
    unsetenv("JACK_DEFAULT_SERVER");
}

}  // namespace pulse_test
