#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "audio/spatial/hrtf.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "tests/audio/player.h"
#include "tests/audio/spatial/spherical_head.h"

using namespace aula;
using namespace aula::test;

namespace {

const std::filesystem::path kCases = AULA_SOURCE_DIR "/tests/cases";

/// Levels of both ears, dB, of the direct sound of a scene without walls.
std::array<double, 2> ear_levels_db(const std::string& file) {
    static const auto hrtf = std::make_shared<const Hrtf>("", kRate_hz);
    const Scene scene = load_scene(kCases / "own_voice" / file).scene;
    const Pose listener = scene.listener.pose_at(0);
    Propagation propagation(scene, scene.simulation);
    propagation.step(
        {.sources = {scene.sources[0].position_at(0)}, .listeners = {listener.position}});
    const SoundPath& path = propagation.response(0).paths.at(0);
    SourceSound sound;
    sound.direct = path_of(480, 1, {path.direction.x, path.direction.y, path.direction.z});
    HeadRotation head;
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 row = listener.rotation()[axis];
        head[static_cast<std::size_t>(axis)] = {row.x, row.y, row.z};
    }
    Player player(config_for(OutputFormat::binaural), hrtf, {impulse(4096)});
    player.publish({sound});
    player.play_until(4096, {256}, head);
    std::array<double, 2> levels_db{};
    for (std::size_t e = 0; e < 2; ++e)
        levels_db[e] = 10 * std::log10(band_energy(player.output(e), 200, 16000, kRate_hz));
    return levels_db;
}

}  // namespace

TEST_CASE("Both ears hear a source at the head equally, whatever the yaw") {
    for (const char* file : {"yaw_0.json", "yaw_90.json", "yaw_180.json", "yaw_270.json"}) {
        const auto [left_db, right_db] = ear_levels_db(file);
        CAPTURE(file, left_db, right_db);
        CHECK(left_db == Approx(right_db).margin(1));
    }
    const auto before = ear_levels_db("minus_1mm.json");
    const auto after = ear_levels_db("plus_1mm.json");
    for (std::size_t e = 0; e < 2; ++e) CHECK(before[e] == Approx(after[e]).margin(1));
}

TEST_CASE("A set of inverted polarity has the interaural delays of the set") {
    for (const char* file : {"positive.sofa", "negative.sofa"}) {
        const Hrtf hrtf(kCases / "inverted_polarity" / file, kRate_hz);
        for (const auto& [azimuth_deg, itd_s] : {std::pair(30.0, 292e-6), {90.0, 583e-6}}) {
            const auto ears = hrtf.ears(direction_at(azimuth_deg, 0));
            CAPTURE(file, azimuth_deg);
            CHECK(low_frequency_itd_s(ears[0].minimum_phase, ears[1].minimum_phase,
                                      ears[1].delay_s - ears[0].delay_s,
                                      kRate_hz) == Approx(itd_s).margin(40e-6));
        }
    }
}
