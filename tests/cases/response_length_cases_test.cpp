#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "apps/room/offline/offline.h"
#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "aula/engine/scene_file.h"
#include "aula/measurement.h"
#include "tests/cases/random_room.h"
#include "tests/support/program.h"

// Responses are as long as rooms sound.

using namespace aula;
using namespace aula::test;

namespace {

constexpr std::size_t kFirstBand = 1;  // 125 Hz
constexpr std::size_t kEndBand = 7;    // 4 kHz is the last

/// Level of the last 50 ms of a response re its loudest 50 ms, in dB.
double end_level_db(const std::vector<float>& samples) {
    constexpr std::size_t kWindow = 2400;
    REQUIRE(samples.size() > 2 * kWindow);
    const auto energy = [&](std::size_t first) {
        double sum = 0;
        for (std::size_t i = first; i < first + kWindow; ++i)
            sum += static_cast<double>(samples[i]) * static_cast<double>(samples[i]);
        return sum;
    };
    double loudest = 0;
    for (std::size_t first = 0; first + kWindow <= samples.size(); first += kWindow / 2)
        loudest = std::max(loudest, energy(first));
    return 10 * std::log10(energy(samples.size() - kWindow) / loudest + 1e-30);
}

/// The sound of offline rendering, mono.
std::vector<float> rendered(const Scene& scene) {
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    OfflineRendering rendering(scene, read_signals(scene, options.sample_rate_hz), options);
    std::vector<float> samples;
    rendering.render(
        [&](std::span<const std::span<const float>> channels) {
            samples.insert(samples.end(), channels[0].begin(), channels[0].end());
        },
        {});
    return samples;
}

Measurement measured(Scene scene, std::optional<float> length_s) {
    scene.simulation.ir_length_s = length_s;
    // The same rays for both lengths: the results differ by the end of the response only.
    return *measure(scene, {.frames = 24, .parameters = false});
}

/// What is wrong with the response of a room by default; empty: nothing. `sounds_long`: a
/// reverberation time exceeds those for which 10 s suffice.
std::string fault_of(const Scene& scene, bool& sounds_long) {
    constexpr double kLongest_s = 8;
    const RoomParameters truth =
        room_parameters(measured(scene, Simulation::kMaxIrLength_s).response(0));
    sounds_long = std::any_of(truth.begin(), truth.end(), [](const BandParameters& band) {
        return !band.t30_s || *band.t30_s > kLongest_s;
    });
    if (sounds_long) return {};
    const Measurement by_default = measured(scene, {});
    const RoomParameters parameters = room_parameters(by_default.response(0));
    std::string fault;
    for (std::size_t b = kFirstBand; b < kEndBand; ++b) {
        const std::string band = " at " + std::to_string(std::lround(kBandCentres_hz[b])) + " Hz";
        if (!parameters[b].t30_s)
            fault += "; no T30" + band;
        else if (std::abs(*parameters[b].t30_s / *truth[b].t30_s - 1) > 0.03)
            fault += "; T30 " + std::to_string(*parameters[b].t30_s) + " s, not " +
                     std::to_string(*truth[b].t30_s) + band;
    }
    const double ir_db =
        end_level_db(ImpulseResponses(by_default, {.output = OutputFormat::mono}).response(0)[0]);
    const double offline_db = end_level_db(rendered(scene));
    if (ir_db > -60) fault += "; the response ends at " + std::to_string(ir_db) + " dB";
    if (offline_db > -60) fault += "; the sound ends at " + std::to_string(offline_db) + " dB";
    double longest_s = 0;
    for (const BandParameters& band : truth) longest_s = std::max(longest_s, *band.t30_s);
    WARN("T30 up to " << longest_s << " s, length " << by_default.length_s << " s, ends at "
                      << ir_db << " and " << offline_db << " dB");
    return fault;
}

int number_from(const char* variable, int absent) {
    const char* const given = std::getenv(variable);
    return given == nullptr ? absent : std::atoi(given);
}

}  // namespace

TEST_CASE("In random rooms a response is as long as the room sounds") {
    const int rooms = number_from("AULA_RESPONSE_LENGTH_ROOMS", 8);
    int tested = 0;
    for (int seed = number_from("AULA_RESPONSE_LENGTH_SEED", 0); tested < rooms; ++seed) {
        const Scene scene = random_room(static_cast<std::uint64_t>(seed));
        INFO("room " << seed);
        bool sounds_long = false;
        const std::string fault = fault_of(scene, sounds_long);
        if (sounds_long) continue;
        CHECK(fault == "");
        ++tested;
    }
}

TEST_CASE("Rooms with an absorbing plane and halls have T30 in every octave by default") {
    struct Case {
        const char* file;
        int frames;
        double t30_s;  ///< of the first source, mean of 500 and 1000 Hz
        double tolerance;
    };
    for (const auto& [file, frames, t30_s, tolerance] :
         {Case{"hall.json", 64, 0.72, 0.05},    // 0.69 to 0.75 by another ray tracer
          Case{"office.json", 16, 2.99, 0.04},  // by a response of 5 s; the noise of 16 frames
          Case{"lecture_hall.json", 16, 2.80, 0.04}}) {
        INFO(file);
        const Scene scene =
            load_scene(std::string(AULA_SOURCE_DIR "/tests/cases/lengths/") + file).scene;
        const Measurement m = *measure(scene, {.frames = frames});
        CHECK(warnings_of(m).empty());
        for (const PairParameters& of_pair : m.parameters)
            for (std::size_t b = 0; b < kBandCount; ++b)
                CHECK(of_pair.octave(AcousticParameter::t30, b).value);
        const auto mean_s =
            m.parameters[0].broadband[static_cast<std::size_t>(AcousticParameter::t30)].value;
        REQUIRE(mean_s);
        CHECK(*mean_s == Approx(t30_s).epsilon(tolerance));
        CHECK(end_level_db(ImpulseResponses(m, {.output = OutputFormat::mono}).response(0)[0]) <
              -60);
    }
}

TEST_CASE("An octave without T30 has a line that says why and what to do") {
    Scene scene = load_scene(std::string(AULA_SOURCE_DIR "/tests/cases/lengths/hall.json")).scene;
    scene.simulation.ir_length_s = 0.2F;
    const Measurement m = *measure(scene, {.frames = 4});
    CHECK(m.warnings.empty());
    REQUIRE(m.missing_decays.size() == 1);
    CHECK_THAT(m.missing_decays[0],
               Catch::Contains("no T30 at 63, 125, 250, 500, 1000, 2000, 4000") &&
                   Catch::Contains("response of 0.2 s") && Catch::Contains("--ir-length auto"));
}

TEST_CASE(
    "The option --ir-length auto leaves the length to the room where the scene or an option sets "
    "it") {
    const auto measured_with = [](std::vector<std::string> options) {
        std::vector<std::string> command{AULA_PROGRAM,
                                         AULA_SOURCE_DIR "/tests/cases/lengths/hall.json",
                                         "--report", "--frames", "2"};
        command.insert(command.end(), options.begin(), options.end());
        return run_program(command);
    };
    const ProgramResult by_default = measured_with({});
    const ProgramResult automatic = measured_with({"--ir-length", "auto"});
    CHECK(automatic.status == 0);
    CHECK(automatic.err.empty());
    CHECK(automatic.out == by_default.out);
    const ProgramResult given = measured_with({"--ir-length", "0.2"});
    CHECK(given.status == 0);
    CHECK_THAT(given.err, Catch::Contains("aula: warning: source \"source1\": no T30 at 63, "));
    const ProgramResult wrong = measured_with({"--ir-length", "long"});
    CHECK(wrong.status == 2);
    CHECK_THAT(wrong.err, Catch::Contains("expected auto, or seconds above 0, at most 10"));
}

TEST_CASE("Rooms behind small openings have long responses with every seed") {
    struct Case {
        const char* file;
        double t30_s;  ///< the longest of the octaves by a response of 10 s
    };
    for (const auto& [file, t30_s] :
         {Case{"four_rooms.json", 2.4}, Case{"small_opening.json", 3}}) {
        Scene scene = load_scene(std::string(AULA_SOURCE_DIR "/tests/cases/lengths/") + file).scene;
        for (std::uint64_t seed = 1; seed <= 8; ++seed) {
            INFO(file << ", seed " << seed);
            scene.simulation.seed = seed;
            // A decay by 60 dB, without the statistical error of about 2 dB.
            CHECK(Propagation(scene, scene.simulation).response_length_s() > 0.95 * t30_s);
        }
    }
}
