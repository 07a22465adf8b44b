#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "apps/room/frames/timeline.h"
#include "apps/room/offline/offline.h"
#include "audio/dsp/loudness.h"
#include "aula/audio/sound_file.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"
#include "aula/measurement.h"
#include "tests/support/temporary_folder.h"

// Level and duration of the sound of the shipped scenes.

using namespace aula;
using namespace aula::test;
namespace fs = std::filesystem;

namespace {

constexpr double kRate_hz = 48000;

/// The rooms that play sounds; the plugin's plays clicks.
std::vector<fs::path> shipped_rooms() {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(fs::path(AULA_SOURCE_DIR) / "scenes"))
        if (entry.path().extension() == ".json" && entry.path().stem() != "default" &&
            entry.path().stem() != "dataset_manifest")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// The longest reverberation time of any octave and source at the start of the walk.
double longest_t30_s(Scene scene) {
    // T30 of 20 frames is known to a few per cent.
    constexpr int kFrames = 20;
    constexpr float kLong_s = 6;
    scene.simulation.ir_length_s = kLong_s;
    double longest_s = 0;
    const auto measurement = measure(scene, {.frames = kFrames});
    for (const EnergyResponse& response : measurement->responses) {
        for (const BandParameters& band : room_parameters(response)) {
            REQUIRE(band.t30_s);
            longest_s = std::max(longest_s, *band.t30_s);
        }
    }
    return longest_s;
}

/// The samples of a float WAV file, interleaved.
std::vector<float> wav_samples(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    constexpr std::string_view kData = "data";
    const auto data = std::search(bytes.begin(), bytes.end(), kData.begin(), kData.end());
    REQUIRE(bytes.end() - data > 8);
    std::vector<float> samples(static_cast<std::size_t>(bytes.end() - data - 8) / sizeof(float));
    std::memcpy(samples.data(), &*data + 8, samples.size() * sizeof(float));
    return samples;
}

struct RenderedLevel {
    double loudness_lufs;
    float peak;
};

/// The binaural rendering of the walk.
RenderedLevel rendered_level(Scene scene, const fs::path& file) {
    // Fewer rays and frames than in the scene: noisier, but equally loud within 0.5 LU.
    scene.simulation.rays = 100;
    scene.simulation.frame_rate_hz = 6;
    REQUIRE(render_offline(scene, {}, file));
    const std::vector<float> samples = wav_samples(file);
    LoudnessMeter meter(kRate_hz, 2);
    meter.add(samples);
    float peak = 0;
    for (const float x : samples) peak = std::max(peak, std::abs(x));
    return {meter.read().integrated_lufs, peak};
}

/// RMS level of a looped sound over a time, in dB.
double level_db(const std::vector<float>& samples, double from_s, double to_s) {
    double sum = 1e-12;
    const auto at = [](double s) { return static_cast<std::size_t>(std::llround(s * kRate_hz)); };
    for (std::size_t i = at(from_s); i < at(to_s); ++i) {
        const double x = static_cast<double>(samples[i % samples.size()]);
        sum += x * x;
    }
    return 10 * std::log10(sum / ((to_s - from_s) * kRate_hz));
}

}  // namespace

TEST_CASE("Every shipped room's response is as long as its reverberation") {
    for (const fs::path& file : shipped_rooms()) {
        INFO(file);
        const Scene scene = load_scene(file).scene;
        // Lengths that follow from the room are tested elsewhere.
        if (!scene.simulation.ir_length_s) continue;
        CHECK(longest_t30_s(scene) < static_cast<double>(*scene.simulation.ir_length_s));
    }
}

TEST_CASE("The shipped scenes are equally loud and do not clip") {
    const TemporaryFolder folder;
    for (const fs::path& file : shipped_rooms()) {
        const RenderedLevel walk =
            rendered_level(load_scene(file).scene, folder.path() / "out.wav");
        INFO(file << ": " << walk.loudness_lufs << " LUFS, peak " << walk.peak);
        // -23 LUFS within 1.5: a pair of scenes differs by at most 3, and by less than 1 with the
        // scenes' settings.
        CHECK(walk.loudness_lufs == Approx(-23).margin(1.5));
        CHECK(walk.peak < 1);
    }
}

TEST_CASE("No shipped walk ends within a sound or at the start of a repetition") {
    for (const fs::path& file : shipped_rooms()) {
        const Scene scene = load_scene(file).scene;
        for (const Source& source : scene.sources) {
            INFO(file << ", " << source.name);
            const auto samples = read_sound(source.signal_file, kRate_hz).samples;
            const double end_s = scene.listener.path->duration_s();
            double loudest_db = -200;
            const double length_s = static_cast<double>(samples.size()) / kRate_hz;
            for (double s = 0; s + 0.05 < length_s; s += 0.05)
                loudest_db = std::max(loudest_db, level_db(samples, s, s + 0.05));
            // Sources are faded out in Timeline::kFade_s from the end of the walk on.
            CHECK(level_db(samples, end_s - 0.05, end_s + Timeline::kFade_s) < loudest_db - 30);
        }
    }
}
