#include "aula/devices/device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>

#include "audio/dsp/fade.h"
#include "aula/audio/sound_file.h"
#include "aula/devices/microphone.h"
#include "aula/exception.h"
#include "tests/audio/device/jack_clients.h"
#include "tests/support/jack_server.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait.h"

using namespace aula;
using namespace aula::test;

// These tests play in real time on a separate server. They check flags and recordings.

namespace {

constexpr double kRate_hz = 48000;
constexpr int kBlock = 256;

/// A tone of 1 kHz at 48 kHz, periodic in 48 samples to the bit.
class Tone {
 public:
    Tone() {
        for (std::size_t n = 0; n < period_.size(); ++n) {
            period_[n] = static_cast<float>(
                0.5 * std::sin(2 * std::numbers::pi * static_cast<double>(n) / 48));
        }
    }
    void operator()(std::span<float* const> outputs, int samples) {
        for (int n = 0; n < samples; ++n, ++time_) {
            for (float* const output : outputs) output[n] = period_[time_ % period_.size()];
        }
    }

 private:
    std::array<float, 48> period_{};
    std::size_t time_ = 0;
};

std::string message_of(const std::string& wanted, double rate_hz, std::size_t channels) {
    try {
        AudioDevice(wanted, rate_hz, channels, kBlock, Tone());
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return {};
}

}  // namespace

namespace {

/// Number of samples of a recording of Tone that differ from those a period before.
std::size_t count_discontinuities(const std::vector<float>& recorded) {
    std::size_t first = 0;
    while (first < recorded.size() && recorded[first] == 0) ++first;
    // The two channels are connected one after the other. At least nine seconds are recorded after
    // that.
    first += 4800;
    REQUIRE(recorded.size() > first + 9 * 48000);
    std::size_t count = 0;
    for (std::size_t n = first + 48; n < recorded.size(); ++n) {
        if (recorded[n] != recorded[n - 48]) ++count;
    }
    CHECK(*std::max_element(recorded.begin(), recorded.end()) == 0.5F);
    return count;
}

}  // namespace

TEST_CASE("Ten seconds of a tone are played in time and without a gap") {
    if (!are_installed("jack_capture")) {
        WARN("skipped: jack_capture is missing (packages-test.txt)");
        return;
    }
    const JackServer server(kBlock);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "recorded.wav";
    // On a busy machine server, recorder and callback can be late and cause a gap. The time in
    // which a virtual machine stands still counts as computing.
    constexpr int kTries = 3;
    for (int attempt = 0; attempt < kTries; ++attempt) {
        AudioDevice device("", kRate_hz, 2, kBlock, Tone());
        JackRecording recording(file, 10);
        if (!recording.running()) {
            WARN("skipped: jack_capture cannot run here");
            return;
        }
        device.start();
        const bool in_time = recording.in_time();
        CHECK(device.active());
        CHECK(device.meter().load() > 0);
        CHECK(device.meter().mean_load() > 0);
        CHECK(device.meter().worst_load() >= device.meter().load());
        device.stop();
        CHECK_FALSE(device.active());
        if (in_time) {
            CHECK(device.meter().rendering_underruns() == 0);
            // Few of the 1900 callbacks follow an underrun, at most at the start.
            CHECK(device.meter().underruns() < 100);
            CHECK(count_discontinuities(read_sound(file, kRate_hz).samples) == 0);
            return;
        }
        std::filesystem::remove(file);
    }
    WARN("skipped: the server was late in every try");
}

TEST_CASE("Devices are listed, selected by index or part of the name, and refused in one line") {
    const JackServer server(kBlock);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const std::vector<DeviceInfo> devices = list_output_devices();
    REQUIRE_FALSE(devices.empty());
    CHECK(devices[0].output_channels >= 2);
    const std::string name = devices[0].name;
    CHECK(AudioDevice(std::to_string(devices[0].index), kRate_hz, 2, kBlock, Tone()).info().name ==
          name);
    CHECK(AudioDevice(name.substr(1), kRate_hz, 2, kBlock, Tone()).info().name == name);

    CHECK_THROWS_AS(AudioDevice("no such device", kRate_hz, 2, kBlock, Tone()), InputError);
    CHECK(message_of("no such device", kRate_hz, 2).find(name) != std::string::npos);
    CHECK_THROWS_AS(AudioDevice("", kRate_hz, 64, kBlock, Tone()), Failure);
    try {
        AudioDevice("", 44100, 2, kBlock, Tone());
        FAIL("a server at 48 kHz took 44.1 kHz");
    } catch (const SampleRateRefused& error) {
        CHECK(error.device_rate_hz() == kRate_hz);
        CHECK(std::string(error.what()).find("48000 Hz, not at 44100 Hz") != std::string::npos);
    }
}

TEST_CASE("A device is lost when its server dies, and plays again when the server returns") {
    auto server = std::make_unique<JackServer>(kBlock);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    std::atomic<int> calls = 0;
    AudioDevice device("", kRate_hz, 2, kBlock,
                       [&, tone = Tone()](std::span<float* const> outputs, int samples) mutable {
                           tone(outputs, samples);
                           ++calls;
                       });
    device.start();
    CHECK(device.state() == DeviceState::playing);
    server.reset();
    CHECK(eventually([&] { return device.state() == DeviceState::lost; }));
    server = std::make_unique<JackServer>(kBlock);
    REQUIRE(server->running());
    CHECK(eventually([&] { return device.state() == DeviceState::playing; }));
    CHECK(device.reconnects() == 1);
    calls = 0;
    CHECK(eventually([&] { return calls > 100; }));
    // The server dies again, and the device is stopped while lost.
    server.reset();
    CHECK(eventually([&] { return device.state() == DeviceState::lost; }));
    device.stop();
    CHECK(device.state() == DeviceState::unavailable);
}

TEST_CASE("A device that returns at another sample rate plays once its samples are prepared") {
    auto server = std::make_unique<JackServer>(kBlock);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    std::atomic<int> asked = 0;  // at the other rate
    std::atomic<int> calls = 0;
    AudioDevice device(
        "", kRate_hz, 2, kBlock,
        [&, tone = Tone()](std::span<float* const> outputs, int samples) mutable {
            tone(outputs, samples);
            ++calls;
        },
        [&](double rate_hz) {
            if (rate_hz != 44100) throw Failure("another rate");
            return ++asked > 2;
        });
    device.start();
    REQUIRE(eventually([&] { return calls > 10; }));
    server.reset();
    REQUIRE(eventually([&] { return device.state() == DeviceState::lost; }));
    server = std::make_unique<JackServer>(kBlock, 2, 44100);
    REQUIRE(server->running());
    calls = 0;
    CHECK(eventually([&] { return device.state() == DeviceState::playing; }));
    // Until then the function has returned false twice; a device that is open asks once more.
    CHECK(asked.load() == 4);
    CHECK(eventually([&] { return calls > 100; }));
    CHECK(device.problem().empty());

    // A rate for which there are no samples: the device stays lost, and says why.
    server.reset();
    REQUIRE(eventually([&] { return device.state() == DeviceState::lost; }));
    server = std::make_unique<JackServer>(kBlock, 2, 32000);
    REQUIRE(server->running());
    CHECK(eventually([&] { return device.problem() == "another rate"; }));
    CHECK(device.state() == DeviceState::lost);
}

TEST_CASE("A device without samples of another rate stays lost, and says why") {
    auto server = std::make_unique<JackServer>(kBlock);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    AudioDevice device("", kRate_hz, 2, kBlock, Tone());
    device.start();
    server.reset();
    REQUIRE(eventually([&] { return device.state() == DeviceState::lost; }));
    server = std::make_unique<JackServer>(kBlock, 2, 44100);
    REQUIRE(server->running());
    CHECK(eventually([&] {
        return device.problem().find("plays at 44100 Hz, not at 48000 Hz") != std::string::npos;
    }));
    CHECK(device.state() == DeviceState::lost);
}

TEST_CASE("Sound starts without a fade, and fades in after a reconnection") {
    constexpr float kLevel = 0.5F;
    auto server = std::make_unique<JackServer>(kBlock);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    auto ear = std::make_unique<JackReceiver>("ear");
    AudioDevice device("ear", kRate_hz, 1, kBlock,
                       [kLevel](std::span<float* const> outputs, int samples) {
                           std::fill_n(outputs[0], samples, kLevel);
                       });
    device.start();
    REQUIRE(eventually([&] { return ear->full(); }));
    CHECK(ear->samples().front() == kLevel);

    // A late server skips blocks; the attempt is then repeated.
    const std::vector<float> rise = raised_cosine(960);  // 20 ms
    constexpr int kTries = 3;
    for (int attempt = 0; attempt < kTries; ++attempt) {
        server.reset();
        REQUIRE(eventually([&] { return device.state() == DeviceState::lost; }));
        ear.reset();
        server = std::make_unique<JackServer>(kBlock);
        REQUIRE(server->running());
        // The device becomes available again.
        ear = std::make_unique<JackReceiver>("ear");
        REQUIRE(eventually([&] { return ear->full(); }));
        if (!ear->in_time()) continue;
        const auto first = std::find_if(rise.begin(), rise.end(), [](float w) { return w > 0; });
        const auto rising = static_cast<std::size_t>(rise.end() - first);
        for (std::size_t n = 0; n < rising; ++n)
            REQUIRE(ear->samples()[n] == kLevel * first[static_cast<std::ptrdiff_t>(n)]);
        CHECK(std::all_of(ear->samples().begin() + static_cast<std::ptrdiff_t>(rising),
                          ear->samples().end(), [](float x) { return x == kLevel; }));
        return;
    }
    WARN("skipped: the server was late in every try");
}

TEST_CASE("A microphone opens the first physical input of the JACK server") {
    auto server = std::make_unique<JackServer>(kBlock);
    if (!server->running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    DeviceInfo jack;
    jack.host_api = "JACK";
    Microphone microphone(jack, kRate_hz, kBlock);
    CHECK(microphone.name() == "system:capture_1");
    CHECK(microphone.alive());

    // It reads all that its port receives: a ramp in each block.
    constexpr float kPeak = 0.25F;
    {
        JackSender sender(kPeak);
        REQUIRE(sender.connect("aula-microphone:in"));
        std::int64_t position = 0;
        std::vector<float> block(kBlock);
        CHECK(eventually([&] {
            microphone.read(position, block);
            position += kBlock;
            return *std::max_element(block.begin(), block.end()) > 0.8F * kPeak;
        }));
    }
    server.reset();
    CHECK(eventually([&] { return !microphone.alive(); }));
}

TEST_CASE("Each channel is connected to the input of its number, with the latency of that input") {
    const JackServer server(kBlock);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    AudioDevice device("system", kRate_hz, 2, kBlock, Tone());
    device.start();
    const std::string connections = run_program({"jack_lsp", "--connections"}).out;
    CHECK(
        connections.find("system:playback_1\n   aula:out_1\nsystem:playback_2\n   aula:out_2\n") !=
        std::string::npos);
    device.stop();

    const JackReceiver ear("ear");
    AudioDevice single("ear", kRate_hz, 1, kBlock, Tone());
    single.start();
    CHECK(single.info().latency_s == Approx(JackReceiver::kMaxLatency / kRate_hz));
}

TEST_CASE("The output of another program is not a microphone") {
    const JackServer server(kBlock, 0);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const JackSender sender(1);
    DeviceInfo jack;
    jack.host_api = "JACK";
    CHECK_THROWS_AS(Microphone(jack, kRate_hz, kBlock), Failure);
}

TEST_CASE("The error without a sound server is one line") {
    setenv("JACK_DEFAULT_SERVER", "aula-test-no-such-server", 1);
    if (!list_output_devices().empty()) {
        WARN("skipped: this machine has a sound device");
        return;
    }
    CHECK_THROWS_AS(AudioDevice("", kRate_hz, 2, kBlock, Tone()), NoAudioDevice);
    const std::string message = message_of("", kRate_hz, 2);
    CHECK(message.find("no audio output device") != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
}
