#include "tests/pd/two_sounds.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/plugin/channels.h"
#include "tests/plugin/host_commands.h"
#include "tests/support/program.h"

namespace aula::test {

namespace {

constexpr std::size_t kSamples = 24000;  // half a second
constexpr std::size_t kLatency = 256;    // of a room on the exact clock (docs/c_api.md)

void write_scene(const TemporaryFolder& folder, const std::string& voice, const std::string& radio,
                 const std::string& listener) {
    folder.write("room.json", R"({"aula": 1,
        "geometry": [{"box": [6, 5, 3], "material": "brick"}],
        "sources": [{"name": "voice", "signal": "a.wav", )" +
                                  voice + R"(}, {"name": "radio", "signal": "b.wav", )" + radio +
                                  R"(}], "listener": {)" + listener + R"(},
        "simulation": {"rays": 100, "ir_length_s": 0.5}})");
}

}  // namespace

void write_two_sounds(const TemporaryFolder& folder) {
    write_mono(folder.path() / "a.wav", noise(12000, 1));
    write_mono(folder.path() / "b.wav", noise(18000, 2));
    write_scene(folder, R"("position": [2, 2, 1.5])", R"("position": [5, 4, 1], "gain_db": -3)",
                R"("position": [4, 2, 1.7], "yaw_deg": 90)");
}

void write_moved_sounds(const TemporaryFolder& folder) {
    write_scene(folder, R"("position": [1, 1.5, 1.25])", R"("position": [5, 4, 1], "gain_db": -20)",
                R"("position": [3, 2, 1.5], "yaw_deg": 45)");
}

float difference_from_offline(const TemporaryFolder& folder, std::size_t recorded_channels,
                              const std::string& output) {
    REQUIRE(run_program({AULA_PROGRAM, folder.path() / "room.json", "--offline",
                         folder.path() / "offline.wav", "--duration", "0.5", "--output", output})
                .status == 0);
    const std::vector<float> offline = wav_samples(folder.path() / "offline.wav");
    const std::vector<float> recorded = wav_samples(folder.path() / "out.wav");
    const std::size_t output_channels = offline.size() / kSamples;
    REQUIRE(recorded.size() >= recorded_channels * (kSamples + kLatency));
    REQUIRE(*std::max_element(offline.begin(), offline.end()) > 0.01F);
    float largest = 0;
    for (std::size_t n = 0; n < kSamples; ++n)
        for (std::size_t c = 0; c < std::min(recorded_channels, output_channels); ++c)
            largest = std::max(largest, std::abs(recorded[recorded_channels * (n + kLatency) + c] -
                                                 offline[output_channels * n + c]));
    return largest;
}

}  // namespace aula::test
