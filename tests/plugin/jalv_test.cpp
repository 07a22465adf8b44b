#include <jack/jack.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include "tests/plugin/host_commands.h"
#include "tests/support/jack_server.h"

// The plugin in jalv, on a private JACK server.

using namespace aula::test;
namespace fs = std::filesystem;

namespace {

constexpr double kTone_hz = 20;
constexpr float kTone_amplitude = 0.25F;

/// A client of the JACK server that sends a tone to a client of jalv and records its two outputs.
class ToneThrough {
 public:
    ToneThrough(const std::string& host, int seconds)
        : recorded_(2, std::vector<float>(static_cast<std::size_t>(seconds) * 48000)) {
        jack_status_t status{};
        client_ = jack_client_open("aula-tone", JackNoStartServer, &status);
        REQUIRE(client_ != nullptr);
        for (const char* name : {"left", "right"})
            inputs_.push_back(
                jack_port_register(client_, name, JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0));
        output_ = jack_port_register(client_, "tone", JACK_DEFAULT_AUDIO_TYPE, JackPortIsOutput, 0);
        jack_set_process_callback(client_, &ToneThrough::process, this);
        jack_set_xrun_callback(client_, &ToneThrough::overrun, this);
        jack_activate(client_);
        connected_ = connect("aula-tone:tone", host + ":in") &&
                     connect(host + ":out_1", "aula-tone:left") &&
                     connect(host + ":out_2", "aula-tone:right");
        starts_ = connected_;
    }
    ~ToneThrough() { stop(); }
    ToneThrough(const ToneThrough&) = delete;
    ToneThrough& operator=(const ToneThrough&) = delete;

    bool connected() const { return connected_; }
    bool in_time() const { return !late_; }

    /// Ends the recording and returns it.
    std::vector<std::vector<float>> stop() {
        if (client_ != nullptr) jack_client_close(client_);
        client_ = nullptr;
        for (auto& channel : recorded_) channel.resize(std::min(count_, channel.size()));
        return recorded_;
    }

 private:
    bool connect(const std::string& from, const std::string& to) {
        // jalv makes its ports after the first frame of the room.
        for (int turn = 0; turn < 600; ++turn) {
            if (jack_connect(client_, from.c_str(), to.c_str()) == 0) return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        return false;
    }
    static int overrun(void* self) {
        ToneThrough& t = *static_cast<ToneThrough*>(self);
        if (t.starts_) t.late_ = true;
        return 0;
    }
    static int process(jack_nframes_t samples, void* self) {
        ToneThrough& t = *static_cast<ToneThrough*>(self);
        auto* const tone = static_cast<float*>(jack_port_get_buffer(t.output_, samples));
        std::fill_n(tone, samples, 0.0F);
        if (!t.starts_) return 0;
        for (jack_nframes_t n = 0; n < samples; ++n) {
            const double time_s = static_cast<double>(t.sent_++) / 48000;
            tone[n] = kTone_amplitude *
                      static_cast<float>(std::min(1.0, time_s) *
                                         std::sin(2 * std::numbers::pi * kTone_hz * time_s));
        }
        for (std::size_t c = 0; c < 2; ++c) {
            const auto* const heard =
                static_cast<const float*>(jack_port_get_buffer(t.inputs_[c], samples));
            for (jack_nframes_t n = 0; n < samples && t.count_ + n < t.recorded_[c].size(); ++n)
                t.recorded_[c][t.count_ + n] = heard[n];
        }
        t.count_ += samples;
        return 0;
    }

    jack_client_t* client_ = nullptr;
    std::vector<jack_port_t*> inputs_;
    jack_port_t* output_ = nullptr;
    bool connected_ = false;
    std::atomic<bool> starts_ = false;
    std::atomic<bool> late_ = false;
    std::uint64_t sent_ = 0;
    std::size_t count_ = 0;
    std::vector<std::vector<float>> recorded_;
};

/// Threads with real-time priority of the processes whose command line contains a text.
int realtime_threads(const std::string& text) {
    int count = 0;
    std::error_code ignored;
    for (const auto& process : fs::directory_iterator("/proc", ignored)) {
        if (read_file(process.path() / "comm") != "jalv\n" ||
            read_file(process.path() / "cmdline").find(text) == std::string::npos)
            continue;
        for (const auto& task : fs::directory_iterator(process.path() / "task", ignored)) {
            const int policy = sched_getscheduler(std::stoi(task.path().filename().string()));
            if (policy == SCHED_FIFO || policy == SCHED_RR) ++count;
        }
    }
    return count;
}

/// What a run of jalv has given.
struct Take {
    std::vector<std::vector<float>> channels;
    int realtime_threads = 0;
};

/// Runs jalv with the lines of a shell script as its input. Discards runs in which the server was
/// late; empty channels if all were, or no server can run.
Take play(const std::string& script, int seconds) {
    for (int attempt = 0; attempt < 3; ++attempt) {
        const JackServer server(256);
        if (!server.running()) break;
        const std::string name = "aula-" + std::to_string(getpid()) + "-" + std::to_string(attempt);
        const TemporaryFolder folder;
        // jalv reads the commands when the tone plays.
        const std::string home = folder.path();
        Program jalv({"env", "LV2_PATH=" AULA_BUNDLES ":/usr/lib/lv2", "HOME=" + home,
                      "XDG_CONFIG_HOME=" + home, "sh", "-c",
                      "cd " + home + " && { until [ -e begin ]; do sleep 0.1; done; " + script +
                          " sleep 1; echo quit; } | jalv -x -n " + name +
                          " -c quality=0 'urn:aula:room#binaural'"});
        ToneThrough tone(name, seconds + 30);
        if (!tone.connected()) {
            jalv.signal(SIGTERM);
            const ProgramResult result = jalv.wait();
            FAIL("jalv has no ports: " << result.out << result.err);
        }
        Take take;
        take.realtime_threads = realtime_threads(name);
        folder.write("begin", "");
        std::this_thread::sleep_for(std::chrono::seconds(seconds));
        take.channels = tone.stop();
        const bool in_time = tone.in_time();
        jalv.wait();
        if (in_time) return take;
    }
    WARN("skipped: no JACK server that is in time can run here");
    return {};
}

}  // namespace

TEST_CASE("In jalv the plugin plays in time while its source moves 20 times a second") {
    if (!has("jalv") || !has("jackd")) return;
    const char* const wanted = std::getenv("AULA_TEST_JALV_SECONDS");
    const int seconds = wanted != nullptr ? std::atoi(wanted) : 10;
    const Take take = play(
        "i=0; while [ $i -lt " + std::to_string(20 * seconds) +
            " ]; do echo set source_x $((3 + i % 5)).$((i % 10)); sleep 0.05; i=$((i+1)); done;",
        seconds);
    if (take.channels.empty()) return;
    // That of JACK, which calls the plugin.
    CHECK(take.realtime_threads == 1);
    for (const auto& channel : take.channels) {
        CHECK(channel.size() > static_cast<std::size_t>(seconds - 1) * 48000);
        CHECK(
            std::all_of(channel.begin(), channel.end(), [](float x) { return std::isfinite(x); }));
        CHECK(std::any_of(channel.begin(), channel.end(), [](float x) { return x > 0.01F; }));
    }
}

TEST_CASE("In jalv bypass has no step above -60 dB") {
    if (!has("jalv") || !has("jackd")) return;
    const Take take = play(
        "for i in 1 2 3; do sleep 1; echo set enabled 0; sleep 1; echo set enabled 1; done;", 7);
    if (take.channels.empty()) return;
    for (const auto& channel : take.channels) {
        float loudest = 0;
        float step = 0;
        for (std::size_t n = 1; n < channel.size(); ++n) {
            loudest = std::max(loudest, std::abs(channel[n]));
            step = std::max(step, std::abs(channel[n] - channel[n - 1]));
        }
        // Bypassed, the tone itself; its steps come in addition.
        CHECK(loudest >= 0.999F * kTone_amplitude);
        const float own =
            loudest * 2 * std::numbers::pi_v<float> * static_cast<float>(kTone_hz) / 48000;
        CHECK(step < own + 0.001F);
    }
}
