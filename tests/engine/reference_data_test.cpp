// Comparison with results of other programs. The data are not part of the project: without them the
// tests are skipped.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "apps/bench/propagation/tracking.h"
#include "aula/engine/propagation.h"
#include "aula/engine/room_acoustics.h"
#include "engine/mesh/mesh_import.h"
#include "engine/rays/room_survey.h"
#include "tests/support/measure.h"
#include "tests/support/rooms.h"
#include "tests/support/shared_data.h"
#include "tests/support/statistics.h"

using namespace aula;
using nlohmann::json;

namespace {

json read_json(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return json::parse(stream);
}

/// The mean response after `frames` of `rays`; the caches continue to accumulate.
EnergyResponse response(const Scene& scene, float length_s, int frames, int rays,
                        float patch_size_m, Estimator estimator = Estimator::patch,
                        std::uint64_t seed = test::test_seed()) {
    Simulation simulation = test::with(scene, estimator, length_s);
    simulation.rays = rays;
    simulation.patch_size_m = patch_size_m;
    simulation.memory_mb = 1000;
    simulation.seed = seed;
    simulation.threads.reset();
    Propagation propagation(scene, simulation);
    // First deposits, then many gathers.
    for (int f = 0; f < frames; ++f) propagation.step(test::static_input(scene));
    return test::mean_response(propagation, scene, frames);
}

/// A box of the reference, with up to eight absorption coefficients in its bands.
struct Box {
    Vec3 size{0};
    float distance_m = 0;
    std::vector<double> absorption, t30_s, c80_db;
};

std::vector<Box> diffuse_boxes(const json& rooms) {
    std::vector<Box> boxes;
    for (const json& room : rooms) {
        if (room["truncated_by_sim_length"].get<bool>()) continue;
        const Vec3 size(room["L"][0].get<float>(), room["L"][1].get<float>(),
                        room["L"][2].get<float>());
        const float distance_m = room["distance_m"].get<float>();
        if (boxes.empty() || boxes.back().size != size || boxes.back().distance_m != distance_m ||
            boxes.back().absorption.size() == kBandCount ||
            boxes.back().absorption.back() > room["alpha"].get<double>()) {
            boxes.push_back({size, distance_m, {}, {}, {}});
        }
        boxes.back().absorption.push_back(room["alpha"].get<double>());
        boxes.back().t30_s.push_back(room["t30_spps"].get<double>());
        boxes.back().c80_db.push_back(room["c80_spps"].get<double>());
    }
    return boxes;
}

}  // namespace

TEST_CASE("diffuse boxes have the reverberation times of another engine") {
    const auto file = test::shared_data("spps_reference/spps_validation.json");
    if (file.empty()) {
        WARN("skipped: no shared/data/spps_reference");
        return;
    }
    int rooms = 0;
    int within_3_percent = 0;
    int within_4_percent = 0;
    int eyring_within_4_percent = 0;
    for (const Box& box : diffuse_boxes(read_json(file).at("rooms"))) {
        Scene scene = test::grey_room(test::box(box.size), 0.5F, 1, box.size / 2.0F,
                                      box.size / 2.0F + Vec3(box.distance_m, 0, 0));
        for (std::size_t b = 0; b < box.absorption.size(); ++b) {
            scene.materials[0].absorption[b] = static_cast<float>(box.absorption[b]);
        }
        scene.simulation.direct = true;
        const double longest_s = *std::max_element(box.t30_s.begin(), box.t30_s.end());
        const EnergyResponse r =
            response(scene, static_cast<float>(0.9 * longest_s), 12, 3000, box.size.x / 10);
        const RoomParameters p = room_parameters(r);
        const double volume_m3 = double{box.size.x} * double{box.size.y} * double{box.size.z};
        const Bands eyring_s =
            eyring_time_s(4 * volume_m3 / test::surface_m2(scene.objects[0]),
                          scene.materials[0].absorption, Bands{}, double{r.speed_of_sound_m_s});
        for (std::size_t b = 0; b < box.absorption.size(); ++b) {
            REQUIRE(p[b].t30_s);
            const double error = *p[b].t30_s / box.t30_s[b] - 1;
            ++rooms;
            within_3_percent += std::abs(error) < 0.03;
            within_4_percent += std::abs(error) < 0.04;
            eyring_within_4_percent += std::abs(double{eyring_s[b]} / box.t30_s[b] - 1) < 0.04;
        }
    }
    CHECK(rooms == 94);
    // Aula's error, below 0.5 %, and the reference's: its T30 deviates by up to 1.5 % from a smooth
    // dependence on absorption.
    CHECK(within_3_percent >= 92);
    CHECK(within_4_percent == 94);
    CHECK(eyring_within_4_percent < 20);  // companion
}

namespace {

/// A room of the radiance-transfer reference: its mesh with the table's materials, which start at a
/// band of the reference; lower bands equal the first one.
Scene modal_room(const std::filesystem::path& mesh_file, const std::filesystem::path& table_file,
                 std::size_t first_band) {
    Scene scene = test::grey_room(Object{}, 0, 0, Vec3(0), Vec3(0));
    scene.materials.clear();
    std::map<std::string, std::uint32_t> index;
    std::ifstream table(table_file);
    std::string line;
    std::getline(table, line);
    while (std::getline(table, line)) {
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream words(line);
        std::string name;
        words >> name;
        std::vector<float> values;
        for (float x = 0; words >> x;) values.push_back(x);
        if (values.empty()) continue;
        const auto [known, added] =
            index.try_emplace(name, static_cast<std::uint32_t>(scene.materials.size()));
        if (added) {
            scene.materials.push_back({name, {}, {}});
            for (std::size_t b = 0; b < kBandCount; ++b) {
                scene.materials.back().absorption[b] = values[b > first_band ? b - first_band : 0];
            }
        } else {
            scene.materials[known->second].scattering = Bands::filled(values[0]);
        }
    }
    const ImportedMesh mesh = import_mesh(mesh_file);
    Object& room = scene.objects[0];
    room.vertices = mesh.vertices;
    room.triangles = mesh.triangles;
    for (const std::uint32_t m : mesh.triangle_materials) {
        // "Patch_7_Mat_Large_exhibit_Ceiling"
        const std::string& name = mesh.material_names[m];
        const auto mark = name.find("_Mat_");
        room.triangle_materials.push_back(
            index.at(mark == std::string::npos ? name : name.substr(mark + 5)));
    }
    scene.medium.air_absorption = true;
    scene.simulation.direct = true;
    scene.simulation.specular_order = 2;
    return scene;
}

/// Time for 60 dB by the decay curve's slope between two levels, in s.
double decay_time_s(const EnergyResponse& response, std::size_t band, double from_db,
                    double to_db) {
    constexpr double kStep_s = 0.01;
    const std::vector<Bands> energy = response.uniform(kStep_s);
    std::vector<double> left(energy.size() + 1, 0);
    for (std::size_t k = energy.size(); k-- > 0;) left[k] = left[k + 1] + double{energy[k][band]};
    double n = 0, t1 = 0, t2 = 0, l1 = 0, tl = 0;
    for (std::size_t k = 0; k < energy.size(); ++k) {
        const double level_db = 10 * std::log10(left[k] / left[0]);
        if (level_db > from_db || level_db < to_db) continue;
        const double t = kStep_s * static_cast<double>(k);
        n += 1, t1 += t, t2 += t * t, l1 += level_db, tl += t * level_db;
    }
    return -60 * (n * t2 - t1 * t1) / (n * tl - t1 * l1);
}

/// Late decay times between two positions, by band, shortened as those of the modes: their delays
/// are truncated to whole milliseconds, on average by half of one for each mean free path.
Bands late_decay_s(Scene scene, double length_s, Estimator estimator, int rays, const Vec3& from,
                   const Vec3& to, std::uint64_t seed = test::test_seed()) {
    scene.sources[0].position = from;
    scene.listener.pose.position = to;
    const std::vector<Vec3> inside{from, to};
    const double free_path_m = survey_room(RayScene(scene), inside, 1).mean_free_path_m;
    const double cut = 1 - 0.0005 * double{scene.medium.speed_of_sound_m_s()} / free_path_m;
    const EnergyResponse r =
        response(scene, static_cast<float>(length_s), 10, rays, 0.6F, estimator, seed);
    Bands time_s;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        time_s[b] = static_cast<float>(decay_time_s(r, b, -25, -45) * cut);
    }
    return time_s;
}

constexpr std::size_t kFirstDecay = 2;  // 250 Hz

/// A room of the data and its modes' times.
struct ModalRoom {
    Scene scene;
    json modes;
    std::size_t first_band = 0;

    double mode_s(std::size_t band, std::size_t mode) const {
        return modes.at(std::to_string(band + 1 - first_band))[mode].get<double>();
    }
    double length_s() const { return 1.2 * mode_s(kFirstDecay, 0); }
};

/// Empty if the data are missing.
std::optional<ModalRoom> modal_room_of(const std::string& room, const std::string& mesh,
                                       const std::string& patches, std::size_t first_band) {
    const auto folder = test::shared_data(room);
    if (folder.empty()) {
        WARN("skipped: no shared/data/" << room);
        return {};
    }
    return ModalRoom{modal_room(folder / mesh, folder / "materials.csv", first_band),
                     read_json(folder / "modart_t60.json").at("t60").at(patches), first_band};
}

/// The mesh to which the table and the modes belong.
std::optional<ModalRoom> museum() {
    return modal_room_of("museum_raves", "mesh_54patches.obj", "Museum_54_patches", 2);
}

/// Late decay times of the patch estimator in the mean over 8 seeds of 2500 rays: a single one
/// deviates by 3 %, at most by 8 %.
Bands mean_late_decay_s(const ModalRoom& room, const Vec3& from, const Vec3& to) {
    constexpr std::uint64_t kSeeds = 8;
    Bands mean_s;
    for (std::uint64_t k = 0; k < kSeeds; ++k) {
        mean_s += late_decay_s(room.scene, room.length_s(), Estimator::patch, 2500, from, to,
                               test::test_seed() + k) *
                  (1.0F / kSeeds);
    }
    return mean_s;
}

/// Checks late decays between pairs of positions against the slowest modes, by band. The modes have
/// few patches: with 30 instead of 20 of them the times of the coupled rooms grow by up to a tenth.
/// The tolerance is 12 % for this, and 2 % for the error of the mean.
void check_late_decays(const ModalRoom& room,
                       const std::array<std::pair<Vec3, Vec3>, 2>& positions) {
    for (const auto& [from, to] : positions) {
        const Bands late_s = mean_late_decay_s(room, from, to);
        std::printf("slower than the mode, from 250 Hz:");
        for (std::size_t b = kFirstDecay; b < kBandCount; ++b) {
            CAPTURE(b);
            std::printf(" %+.1f %%", 100 * (double{late_s[b]} / room.mode_s(b, 0) - 1));
            CHECK(double{late_s[b]} == Approx(room.mode_s(b, 0)).epsilon(0.14));
            // Companion: the next mode.
            CHECK(double{late_s[b]} != Approx(room.mode_s(b, 1)).epsilon(0.14));
        }
        std::printf("\n");
    }
}

}  // namespace

TEST_CASE("the late decay of coupled rooms has the rate of their slowest mode") {
    if (const auto room = modal_room_of("coupled_rooms_art", "mesh_materials.obj",
                                        "AudioForGames_30_patches", 1)) {
        check_late_decays(*room, {{{Vec3(7, 3.5F, 1.5F), Vec3(5, 3, 1.5F)},
                                   {Vec3(2, 4, 1.5F), Vec3(8, 10, 1.5F)}}});
    }
}

TEST_CASE("the late decay of the museum has the rate of its slowest mode") {
    if (const auto room = museum()) {
        check_late_decays(*room, {{{Vec3(10.5F, 15, 1.5F), Vec3(10.5F, 14, 1.2F)},
                                   {Vec3(4, 15, 1.5F), Vec3(4, 22, 1.5F)}}});
    }
}

TEST_CASE("the late decay in the museum's large room agrees with plain path tracing") {
    const auto room = museum();
    if (!room) return;
    const Vec3 from(2.5F, 11, 1.5F);
    const Vec3 to(5.5F, 16, 1.2F);
    const Bands patch_s = mean_late_decay_s(*room, from, to);
    const Bands path_s =
        late_decay_s(room->scene, room->length_s(), Estimator::pt, 50000, from, to);
    for (std::size_t b = kFirstDecay; b < kBandCount; ++b) {
        const auto slower_percent = [&](const Bands& time_s) {
            return 100 * (double{time_s[b]} / room->mode_s(b, 0) - 1);
        };
        std::printf(
            "museum's large room: %5.0f Hz, slower than the mode: patch %+5.1f %%, pt %+5.1f %%\n",
            double{kBandCentres_hz[b]}, slower_percent(patch_s), slower_percent(path_s));
        // Statistical: from seed to seed either strays by 1 %, a tenth of the bands by 2 %.
        CHECK(patch_s[b] == Approx(path_s[b]).epsilon(0.05));
        // Companion: the time of the mode, too short because of its few patches.
        CHECK(double{patch_s[b]} != Approx(room->mode_s(b, 0)).epsilon(0.05));
    }
}

TEST_CASE("with air a diffuse box decays as in another engine's table") {
    const auto file = test::shared_data("spps_reference/spps_validation.json");
    if (file.empty()) {
        WARN("skipped: no shared/data/spps_reference");
        return;
    }
    const json times_s = read_json(file).at("air_absorption").at("results").at("spps").at("rt_s");
    Scene scene = test::grey_room(test::box(Vec3(5, 4, 3)), 0.1F, 1, Vec3(2.5F, 2, 1.5F), Vec3(1));
    scene.simulation.direct = true;
    scene.medium.air_absorption = true;  // 20 C, 50 %, as in the reference
    const RoomParameters p = room_parameters(response(scene, 0.9F, 8, 2500, 0.5F));
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const std::string band = std::to_string(std::lround(kBandCentres_hz[b]));
        REQUIRE(p[b].t30_s);
        CAPTURE(band);
        // Both engines' noise; measured 0.1 %, at 8 kHz 0.7 %.
        CHECK(*p[b].t30_s == Approx(times_s[band].get<double>()).epsilon(0.01));
    }
    // Companion: the time of the band below differs, from 2 kHz on by more than 2 %.
    for (std::size_t b = 5; b < kBandCount; ++b) {
        const std::string below = std::to_string(std::lround(kBandCentres_hz[b - 1]));
        CHECK(*p[b].t30_s != Approx(times_s[below].get<double>()).epsilon(0.01));
    }
}

TEST_CASE("a walk through a game level is tracked without lag") {
    const auto file = test::shared_data("openarena/oa_dm1.obj");
    if (file.empty()) {
        WARN("skipped: no shared/data/openarena");
        return;
    }
    ImportedMesh mesh = import_mesh(file);
    // Its y is up.
    for (Vec3& v : mesh.vertices) v = Vec3(v.x, -v.z, v.y);
    Object level;
    level.vertices = std::move(mesh.vertices);
    level.triangles = std::move(mesh.triangles);
    level.triangle_materials.assign(level.triangles.size(), 0);
    const Vec3 from(-17.5F, 24, 1.35F);  // a spawn point of the level; the source is at another one
    Scene scene = test::grey_room(level, 0.1F, 1, Vec3(-20.5F, 30.5F, 1.35F), from);
    scene.simulation.rays = 1000;
    scene.listener.path = Trajectory{{{0, {from}}, {4, {from + Vec3(0, 6, 0)}}}, false};

    bench::Settings settings;
    settings.positions = 4;
    settings.reference_rays = 1e6;
    settings.progress = [](const std::string&) {};
    settings.estimators = {Estimator::pt, Estimator::patch};
    const auto number = [](const bench::Row& row, const char* figure) {
        return std::get<double>(row.at(figure));
    };
    int checked = 0;
    for (const bench::Row& row : measure_tracking({"level", scene, settings}, settings)) {
        const auto& mover = std::get<std::string>(row.at("mover"));
        const auto& estimator = std::get<std::string>(row.at("estimator"));
        if (std::get<std::string>(row.at("basis")) != "rays" || mover == "both") continue;
        const double error = number(row, "tracking_error");
        std::printf("a game's level: %s walks, %s: tracking error %.3f, energy ratio %.3f\n",
                    mover.c_str(), estimator.c_str(), error, number(row, "energy_ratio"));
        // Measured: 0.031 and 0.026. Companion: plain path tracing, 0.68 and 0.71.
        CHECK((error < 0.05) == (estimator == "patch"));
        ++checked;
    }
    CHECK(checked == 4);
}
