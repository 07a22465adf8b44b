#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/plugin/host_commands.h"
#include "tests/support/octave.h"

// The binaural plugin in sessions of Ardour, without a window.

namespace {

using namespace aula::test;
namespace fs = std::filesystem;

constexpr std::size_t kSeconds = 3;
constexpr int kAttempts = 6;
const std::string kScripts = std::string(AULA_SOURCE_DIR) + "/tests/plugin/ardour/";

struct Format {
    std::string type;
    std::string plugin;
};
const Format kLv2{"LV2", "urn:aula:room#binaural"};
const Format kVst3{"VST3", "41756C61526F6F6D6D6F6E6F62696E00"};

#ifdef AULA_VST3_BUNDLE
constexpr bool kHasVst3 = true;
#else
constexpr bool kHasVst3 = false;
#define AULA_VST3_BUNDLE ""
#endif

/// A session with three seconds of noise on its track, in a scratch folder that is the home, too.
class Session {
 public:
    /// `settings`: further environment of create.lua.
    Session(const Format& format, const std::string& settings) {
        std::mt19937 random(1);
        std::normal_distribution<float> noise(0, 0.1F);
        std::vector<float> voice(kSeconds * 48000);
        std::generate(voice.begin(), voice.end(), [&] { return noise(random); });
        const fs::path presets = folder_.path() / "ardour7/export";
        const fs::path sounds = folder_.path() / "session/interchange/session/audiofiles";
        fs::create_directories(presets);
        fs::copy_file(kScripts + "float.preset", presets / "float.preset");
        if (format.type == "VST3") scan();
        run("TYPE=" + format.type + " PLUGIN='" + format.plugin + "' " + settings, "create.lua",
            "created\n");
        fs::create_directories(sounds);
        write_mono(sounds / "voice.wav", voice);
        write_mono(folder_.path() / "voice.wav", voice);
    }

    const TemporaryFolder& folder() const { return folder_; }

    /// Loads the session and exports it. Returns the line of the ports.
    std::string export_takes(int takes, std::size_t buffer, std::size_t samples) const {
        const std::string log =
            run("BUFFER=" + std::to_string(buffer) + " SAMPLES=" + std::to_string(samples) +
                    " TAKES=" + std::to_string(takes) + " FOLDER=.",
                "export.lua", "exported\n");
        const std::size_t ports = log.find("ports: ");
        REQUIRE(ports != std::string::npos);
        return log.substr(ports, log.find('\n', ports) - ports);
    }

    std::vector<float> exported(std::size_t buffer, int take) const {
        return wav_samples(folder_.path() / name(buffer, take));
    }

    /// SHA-256 of the audio data of the exported file, in hexadecimal digits. Of the whole file it
    /// differs: Ardour writes the date into it.
    std::string sha256(std::size_t buffer, int take) const {
        const std::string file = read_file(folder_.path() / name(buffer, take));
        std::size_t chunk = std::string("RIFFsizeWAVE").size();
        std::uint32_t bytes = 0;
        for (;; chunk += 8 + bytes + bytes % 2) {
            REQUIRE(chunk + 8 <= file.size());
            std::memcpy(&bytes, file.data() + chunk + 4, sizeof bytes);
            if (file.compare(chunk, 4, "data") == 0) break;
        }
        const fs::path data = folder_.write("data", file.substr(chunk + 8, bytes));
        const ProgramResult result = run_host(folder_, "sha256sum < '" + data.string() + "'");
        REQUIRE(result.status == 0);
        return result.out.substr(0, 64);
    }

 private:
    /// Ardour uses VST3 plugins that its scanner has listed.
    void scan() const {
        const fs::path plugins = folder_.path() / ".vst3";
        fs::create_directories(plugins);
        fs::create_directory_symlink(AULA_VST3_BUNDLE, plugins / "aula.vst3");
        const ProgramResult result =
            run_host(folder_,
                     "LD_LIBRARY_PATH=/usr/lib/ardour7 /usr/lib/ardour7/ardour-vst3-scanner"
                     " -f -v $PWD/.vst3/aula.vst3");
        INFO(result.out << result.err);
        REQUIRE((result.out + result.err).find("aula.room.stereo.toa") != std::string::npos);
    }

    static std::string name(std::size_t buffer, int take) {
        return std::to_string(buffer) + "_" + std::to_string(take) + ".wav";
    }

    /// Runs a script; returns what Ardour prints, with the line `end`. Ardour 7.3 often crashes
    /// while it closes a session, with any plugin, and sometimes before: further attempts follow.
    std::string run(const std::string& settings, const std::string& script,
                    const std::string& end) const {
        std::string log;
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            const ProgramResult result =
                run_host(folder_, settings + " SESSION=$PWD/session timeout 100 ardour7-lua < '" +
                                      kScripts + script + "'");
            log = result.out + result.err;
            if (log.find(end) != std::string::npos) return log;
        }
        FAIL(log);
        return log;
    }

    TemporaryFolder folder_;
};

/// Energy in half a second, dB.
double level_db(const std::vector<double>& signal, std::size_t half) {
    double energy = 0;
    for (std::size_t n = half * 24000; n < (half + 1) * 24000; ++n) energy += signal[n] * signal[n];
    return 10 * std::log10(energy);
}

std::vector<float> channel(const std::vector<float>& interleaved, std::size_t index) {
    std::vector<float> samples;
    for (std::size_t n = index; n < interleaved.size(); n += 2) samples.push_back(interleaved[n]);
    return samples;
}

}  // namespace

TEST_CASE("Ardour exports the same audio data from a loaded session at all buffer sizes") {
    if (!has("ardour7-lua")) return;
    // The places of the preset, the gain and the quality: fewer rays are a faster export. VST3 has
    // no presets in Ardour.
    const std::pair lv2{kLv2, "PRESET='Bright Room' VALUES='9=-3 14=0'"};
    const std::pair vst3{kVst3, "VALUES='0=6.5 1=4.5 2=1.4 3=3.2 4=3.6 5=1.6 6=0.01 9=-3 14=0'"};
    const auto [format, settings] = kHasVst3 ? GENERATE_COPY(lv2, vst3) : lv2;
    INFO(format.type);
    const Session session(format, settings);
    constexpr std::size_t kSamples = 72000;
    std::vector<float> first;
    std::string first_sha256;
    // The session is closed and loaded between the sizes.
    for (const std::size_t buffer : {64U, 256U, 1024U}) {
        INFO(buffer);
        CHECK(session.export_takes(2, buffer, kSamples) ==
              "ports: 6.5 4.5 1.4 3.2 3.6 1.6 0.01 0 0 -3 1 1 1 1 0");
        for (const int take : {1, 2}) {
            const std::vector<float> samples = session.exported(buffer, take);
            REQUIRE(samples.size() == 2 * kSamples);
            const std::string sha256 = session.sha256(buffer, take);
            if (first.empty()) {
                first = samples;
                first_sha256 = sha256;
            }
            CHECK(samples == first);
            CHECK(sha256 == first_sha256);
        }
    }
    CHECK(std::any_of(first.begin(), first.end(), [](float x) { return std::abs(x) > 0.01F; }));
}

TEST_CASE("Automation of the source in Ardour sounds like the same walk offline") {
    if (!has("ardour7-lua")) return;
    const Session session(kLv2, "");
    session.export_takes(1, 256, kSeconds * 48000);
    std::string scene = read_file(std::string(AULA_SOURCE_DIR) + "/scenes/default.json");
    const std::string still = R"("position": [6.5, 4.25, 1.5], "signal": "impulse", "loop": true)";
    const std::size_t at = scene.find(still);
    REQUIRE(at != std::string::npos);
    scene.replace(at, still.size(),
                  R"("signal": "voice.wav", "path": {"points": [
                     {"t": 0, "position": [6.5, 4.25, 1.5]},
                     {"t": 3, "position": [4.5, 4.25, 1.5]}]})");
    const fs::path walk = session.folder().write("walk.json", scene);
    const fs::path offline = session.folder().path() / "walk.wav";
    const ProgramResult rendered = run_program(
        {AULA_PROGRAM, walk, "--offline", offline, "--output", "binaural", "--duration", "3"});
    INFO(rendered.err);
    REQUIRE(rendered.status == 0);
    const std::vector<float> wanted = wav_samples(offline);
    const std::vector<float> exported = session.exported(256, 1);
    REQUIRE(exported.size() == wanted.size());
    for (const std::size_t ear : {0U, 1U}) {
        const std::vector<float> from_host = channel(exported, ear);
        const std::vector<float> from_program = channel(wanted, ear);
        for (const double centre_hz : {63, 125, 250, 500, 1000, 2000, 4000, 8000}) {
            const std::vector<double> heard = octave(from_host, centre_hz, 48000);
            const std::vector<double> right = octave(from_program, centre_hz, 48000);
            for (std::size_t half = 0; half < 2 * kSeconds; ++half) {
                INFO("ear " << ear << ", " << centre_hz << " Hz, half second " << half);
                CHECK(std::abs(level_db(heard, half) - level_db(right, half)) < 0.1);
            }
        }
    }
}
