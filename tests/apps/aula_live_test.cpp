#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>
#include <vector>

#include "audio/sound_file.h"
#include "tests/support/jack_server.h"
#include "tests/support/octave.h"
#include "tests/support/program.h"

namespace {

using namespace aula::test;

constexpr double kRate_hz = 48000;

/// The lag in samples at which `late` is most like `early`: first by their loudness in
/// milliseconds, then by the samples themselves.
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

/// What the program says at its end.
struct Played {
    unsigned underruns = 0;
    unsigned own_underruns = 0;  ///< those because rendering took too long
    unsigned frames = 0;
    unsigned late = 0;  ///< frame times left out
};

Played read_summary(const std::string& text) {
    Played played;
    const std::size_t at = text.find("underruns ");
    REQUIRE(at != std::string::npos);
    REQUIRE(std::sscanf(text.c_str() + at, "underruns %u, frames %u (%u late)", &played.underruns,
                        &played.frames, &played.late) == 3);
    const std::string ours = "ours: ";
    for (std::size_t of = text.find(ours); of != std::string::npos; of = text.find(ours, of + 1))
        ++played.own_underruns;
    return played;
}

/// More wants to run than there are processors.
bool machine_is_busy() {
    double load = 0;
    return getloadavg(&load, 1) == 1 && load > std::thread::hardware_concurrency();
}

}  // namespace

TEST_CASE("Live on a JACK server rendering is never late, and what is heard is what is rendered") {
    const TemporaryFolder folder;
    const std::string scene = AULA_SOURCE_DIR "/scenes/two_rooms.json";
    const std::string heard_file = folder.path() / "heard.wav";
    const std::string rendered_file = folder.path() / "rendered.wav";
    const JackServer server(256);
    if (!server.running()) {
        WARN("skipped: no JACK server can run here");
        return;
    }
    // A machine that is busy with other things slips now and then whatever it plays; a program that
    // is at fault does so each time.
    constexpr int kAttempts = 3;
    Played played;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        JackRecording recording(heard_file, 20);
        if (!recording.running()) {
            WARN("skipped: jack_capture cannot run here");
            return;
        }
        const ProgramResult live = run_program({AULA_PROGRAM, scene, "--no-window"});
        recording.wait();
        INFO(live.err);
        REQUIRE(live.status == 0);
        played = read_summary(live.err);
        if (played.own_underruns == 0) break;
        WARN("attempt " << attempt + 1 << ": " << live.err);
    }
    // Where propagation cannot keep up the walk is heard late, and no comparison is fair.
    if (10 * played.late > played.frames || (played.own_underruns > 0 && machine_is_busy())) {
        WARN("skipped: this machine is too busy to play");
        return;
    }
    // What the server itself comes late with, a block or a few, is not heard in half a second's
    // level; more of it leaves nothing to compare.
    REQUIRE(played.own_underruns == 0);
    if (played.underruns > 8) {
        WARN("skipped: the JACK server comes late on this machine");
        return;
    }
    const ProgramResult offline = run_program({AULA_PROGRAM, scene, "--offline", rendered_file});
    REQUIRE(offline.status == 0);

    const auto heard = aula::read_sound(heard_file, kRate_hz).samples;
    const auto rendered = aula::read_sound(rendered_file, kRate_hz).samples;
    const std::size_t shift = lag(rendered, heard);
    REQUIRE(shift + rendered.size() / 2 < heard.size());

    // The listener is heard one frame later live, 1/30 s: the walk is 5 cm behind. 1 dB is the
    // just noticeable difference of level. What is 40 dB below the loudest half second is pauses.
    constexpr std::size_t kHalfSecond = 24000;
    constexpr double kPauses = 1e-4;
    std::size_t compared = 0;
    for (const double centre_hz : {250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0}) {
        const auto a = octave(rendered, centre_hz, kRate_hz);
        const auto b = octave(heard, centre_hz, kRate_hz);
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
            CHECK(10 * std::log10(heard_energy / rendered_energy) == Approx(0).margin(1));
            ++compared;
        }
    }
    REQUIRE(compared > 60);
}
