#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <thread>
#include <utility>
#include <vector>

#include "apps/room/live/player.h"
#include "apps/room/offline/offline.h"
#include "aula/audio/sound_file.h"
#include "aula/devices/device.h"
#include "aula/engine/scene_file.h"
#include "tests/support/jack_server.h"
#include "tests/support/octave.h"
#include "tests/support/program.h"
#include "tests/support/pulse_server.h"
#include "tests/support/small_scenes.h"
#include "tests/support/wait.h"

// As declared in audio/device/port_audio_output.cpp.
extern "C" [[gnu::weak]] void PaUtil_SetDebugPrintFunction(void (*print)(const char* message));

namespace {

using namespace aula::test;

constexpr double kRate_hz = 48000;

/// The lag in samples that maximises the correlation of `late` with `early`: first of the envelopes
/// in steps of 1 ms, then of the samples.
std::size_t lag(const std::vector<float>& early, const std::vector<float>& late) {
    constexpr std::size_t kMillisecond = 48;
    const auto best = [](const std::vector<float>& a, const std::vector<float>& b, std::size_t from,
                         std::size_t to) {
        std::size_t best_lag = from;
        double best_product = -1;
        for (std::size_t l = from; l <= to; ++l) {
            double product = 0;
            for (std::size_t i = 0; i < a.size() && i + l < b.size(); ++i)
                product += static_cast<double>(a[i]) * static_cast<double>(b[i + l]);
            if (product > best_product) {
                best_product = product;
                best_lag = l;
            }
        }
        return best_lag;
    };
    const auto loudness = [](const std::vector<float>& samples) {
        std::vector<float> out(samples.size() / kMillisecond);
        for (std::size_t i = 0; i < out.size() * kMillisecond; ++i)
            out[i / kMillisecond] += std::abs(samples[i]);
        return out;
    };
    const auto a = loudness(early);
    const auto b = loudness(late);
    const std::size_t coarse = kMillisecond * best(a, b, 0, b.size() / 2);
    const std::size_t from = coarse - std::min(coarse, 3 * kMillisecond);
    return best(early, late, from, coarse + 3 * kMillisecond);
}

/// True if the load average exceeds the number of processors.
bool machine_is_busy() {
    double load = 0;
    return getloadavg(&load, 1) == 1 && load > std::thread::hardware_concurrency();
}

/// True once the server plays samples that are not zero.
bool sound_arrives(const PulseServer& server, const TemporaryFolder& folder) {
    constexpr std::streamoff kHeader = 4096;  // longer than any WAV header
    const std::filesystem::path played = folder.path() / "played.wav";
    std::filesystem::remove(played);
    const auto recorder = server.record(played);
    return eventually([&] {
        std::ifstream file(played, std::ios::binary);
        file.seekg(kHeader);
        return std::any_of(std::istreambuf_iterator<char>(file), {}, [](char c) { return c != 0; });
    });
}

}  // namespace

TEST_CASE("Without a device the program plays for the requested duration") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const ProgramResult played =
        run_program({AULA_PROGRAM, scene, "--no-window", "--device", "none", "--duration", "1"});
    INFO(played.err);
    CHECK(played.status == 0);
    CHECK(played.out.empty());
    CHECK(played.err.find("played 1.0 s, ") != std::string::npos);
    CHECK(played.err.find("is lost") == std::string::npos);
}

TEST_CASE(
    "With --osc the program plays beyond the end of the scene, for --duration or until quit") {
    const TemporaryFolder folder;
    std::string text = kSmallRoom;
    text.replace(text.find("\"t\": 1"), 6, "\"t\": 0.1");
    const std::string scene = folder.write("room.json", text);
    const std::vector<std::string> play{AULA_PROGRAM, scene, "--no-window", "--device", "none"};
    const auto with = [&](std::vector<std::string> options) {
        options.insert(options.begin(), play.begin(), play.end());
        return options;
    };
    const auto played_s = [](const ProgramResult& result) {
        double s = 0;
        const std::size_t at = result.err.find("played ");
        INFO(result.err);
        REQUIRE(at != std::string::npos);
        REQUIRE(std::sscanf(result.err.c_str() + at, "played %lf s", &s) == 1);
        return s;
    };
    Program endless(with({"--osc", "0"}));
    // Meanwhile the scene ends twice.
    for (int time = 0; time < 2; ++time) CHECK(played_s(run_program(play)) < 1);
    REQUIRE(eventually([&] { return !endless.err().empty(); }));
    const ProgramResult limited = run_program(with({"--osc", "0", "--duration", "1"}));
    CHECK(limited.status == 0);
    CHECK(played_s(limited) == Approx(1));
    REQUIRE(endless.running());
    endless.signal(SIGINT);
    const ProgramResult ended = endless.wait();
    CHECK(ended.status == 130);
    CHECK(played_s(ended) > 1);
}

TEST_CASE("If no device exists, the error message names the option to play without one") {
    if (!aula::list_output_devices().empty()) {
        WARN("skipped: this machine has a sound device");
        return;
    }
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const ProgramResult played = run_program({AULA_PROGRAM, scene, "--no-window"});
    INFO(played.err);
    CHECK(played.status == 1);
    CHECK(played.err.find("--device none") != std::string::npos);
    CHECK(std::count(played.err.begin(), played.err.end(), '\n') == 1);
}

TEST_CASE("The end and the return of a PulseAudio server are reported with one line each") {
    if (PaUtil_SetDebugPrintFunction == nullptr) {
        WARN("skipped: without PortAudio's archive its messages cannot be suppressed");
        return;
    }
    PulseServer server;
    if (!server.running()) {
        WARN("skipped: no PulseAudio server can run here");
        return;
    }
    if (run_program({AULA_PROGRAM, "--list-devices"}).out.find("pulse") == std::string::npos) {
        WARN("skipped: ALSA knows no PulseAudio here (libasound2-plugins)");
        return;
    }
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    Program program(
        {AULA_PROGRAM, scene, "--no-window", "--device", "pulse", "--duration", "1000"});
    // Wait for sound: PortAudio reports a server's end only seconds later if the stream is still
    // being started.
    REQUIRE(sound_arrives(server, folder));
    server.kill();
    const auto says = [&](const std::string& text) {
        return eventually([&] { return program.err().find(text) != std::string::npos; });
    };
    CHECK(says("is lost"));
    server.restart();
    REQUIRE(server.running());
    CHECK(says("is available again"));
    CHECK(sound_arrives(server, folder));
    program.signal(SIGINT);
    REQUIRE(eventually([&] { return !program.running(); }));
    const ProgramResult played = program.wait();
    INFO(played.err);
    CHECK(played.status == 130);
    std::istringstream lines(played.err);
    std::string line;
    std::size_t reports = 0;
    while (std::getline(lines, line) && !line.starts_with("played ")) {
        CHECK(line.starts_with("aula: warning: "));
        if (line.find("the output device \"pulse\"") != std::string::npos) ++reports;
    }
    CHECK(reports == 2);
    CHECK(line.starts_with("played "));
}

TEST_CASE("Live sound equals the offline rendering, and the program reports its latency") {
    const JackServer server(256);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    const TemporaryFolder folder;
    const std::string scene_file = AULA_SOURCE_DIR "/scenes/two_rooms.json";
    const ProgramResult live =
        run_program({AULA_PROGRAM, scene_file, "--no-window", "--duration", "1"});
    INFO(live.err);
    REQUIRE(live.status == 0);
    unsigned underruns = 0;
    unsigned frames = 0;
    const std::size_t summary = live.err.find("underruns ");
    REQUIRE(summary != std::string::npos);
    REQUIRE(std::sscanf(live.err.c_str() + summary, "underruns %u, frames %u", &underruns,
                        &frames) == 2);
    CHECK(frames > 0);

    // The player records the walk, which excludes gaps caused by the server. A busy machine causes
    // occasional underruns; a fault of the program causes them in each attempt.
    const auto played_file = folder.path() / "played.wav";
    const auto rendered_file = folder.path() / "rendered.wav";
    const aula::Scene scene = aula::load_scene(scene_file).scene;
    constexpr int kAttempts = 3;
    aula::PlayStatus status;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        aula::Player player(scene, {});
        player.record(played_file);
        do {
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
            status = player.status();
        } while (!status.finished);
        player.stop_recording();
        if (status.rendering_underruns == 0) break;
    }
    // If propagation is too slow, the walk takes effect late and the comparison is invalid.
    if (50 * status.late_frames > status.frames ||
        (status.rendering_underruns > 0 && machine_is_busy())) {
        WARN("skipped: this machine is too busy to play");
        return;
    }
    CHECK(status.rendering_underruns == 0);
    REQUIRE(aula::render_offline(scene, {}, rendered_file));

    // The recording began slightly after playback, or before the first sound by the limiter's
    // delay.
    const auto rendered = aula::read_sound(rendered_file, kRate_hz).samples;
    auto played = aula::read_sound(played_file, kRate_hz).samples;
    played.insert(played.begin(), static_cast<std::size_t>(kRate_hz), 0);
    const std::size_t shift = lag(rendered, played);
    REQUIRE(shift + rendered.size() / 2 < played.size());

    // Live poses take effect one frame later, 1/30 s: the walk lags by 5 cm. 1 dB is the just
    // noticeable difference of level. Half seconds 40 dB below the loudest one are pauses.
    constexpr std::size_t kHalfSecond = 24000;
    constexpr double kPauses = 1e-4;
    std::size_t compared = 0;
    for (const double centre_hz : {250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0}) {
        const auto a = octave(rendered, centre_hz, kRate_hz);
        const auto b = octave(played, centre_hz, kRate_hz);
        std::vector<std::pair<double, double>> energies;
        for (std::size_t at = 0; at + kHalfSecond <= a.size(); at += kHalfSecond) {
            if (at + shift + kHalfSecond > b.size()) break;
            auto& [rendered_energy, heard_energy] = energies.emplace_back(0, 0);
            for (std::size_t i = at; i < at + kHalfSecond; ++i) {
                rendered_energy += a[i] * a[i];
                heard_energy += b[i + shift] * b[i + shift];
            }
        }
        const double loudest = std::max_element(energies.begin(), energies.end())->first;
        for (std::size_t window = 0; window < energies.size(); ++window) {
            const auto [rendered_energy, heard_energy] = energies[window];
            if (rendered_energy < kPauses * loudest) continue;
            INFO(centre_hz << " Hz, from " << 0.5 * static_cast<double>(window) << " s");
            // Below 1 kHz the reverberation differs over 5 cm, as that of a diffuse field does.
            CHECK(10 * std::log10(heard_energy / rendered_energy) ==
                  Approx(0).margin(centre_hz < 1000 ? 1.5 : 1));
            ++compared;
        }
    }
    REQUIRE(compared > 60);
}
