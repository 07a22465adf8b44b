#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "aula/engine/scene_file.h"
#include "engine/rays/ray_scene.h"

using aula::LoadedScene;
using aula::RayScene;
using aula::Scene;
using aula::Trajectory;
using aula::Vec3;
namespace fs = std::filesystem;

namespace {

const fs::path kScenes = fs::path(AULA_SOURCE_DIR) / "scenes";

/// The scene files in a folder, without its subfolders, by name.
std::vector<fs::path> scene_files(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() == ".json" && entry.path().stem() != "dataset_manifest")
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

/// The rooms with a walk and sounds: all but the plugin's room, in which the host moves the
/// listener and plays the sound.
std::vector<fs::path> walked_rooms() {
    std::vector<fs::path> rooms = scene_files(kScenes);
    std::erase(rooms, kScenes / "default.json");
    return rooms;
}

/// The share of rays in all directions that leave the scene.
double escaping_share(const RayScene& scene, const Vec3& from) {
    constexpr int kRays = 1000;
    std::vector<aula::Ray> rays;
    for (int i = 0; i < kRays; ++i) {  // a Fibonacci lattice on the sphere
        const double z = 1 - (2 * i + 1.0) / kRays;
        const double angle = std::numbers::pi * (3 - std::sqrt(5.0)) * i;
        const double r = std::sqrt(1 - z * z);
        rays.push_back({from, Vec3(r * std::cos(angle), r * std::sin(angle), z)});
    }
    std::vector<aula::Hit> hits(rays.size());
    scene.intersect(rays, hits);
    const auto lost =
        std::count_if(hits.begin(), hits.end(), [](const auto& h) { return !h.any(); });
    return static_cast<double>(lost) / kRays;
}

/// True if head, chest and knees of a walker are unobstructed between two points of a walk.
bool is_unobstructed(const RayScene& scene, const Vec3& from, const Vec3& to) {
    constexpr std::array<float, 3> kBelowHead_m{0, 0.5F, 1.1F};
    return std::all_of(kBelowHead_m.begin(), kBelowHead_m.end(), [&](float below_m) {
        const Vec3 down(0, 0, below_m);
        return scene.visible(from - down, to - down);
    });
}

double turned_by_deg(double from_rad, double to_rad) {
    return std::abs(std::remainder(to_rad - from_rad, 2 * std::numbers::pi)) * 180 /
           std::numbers::pi;
}

}  // namespace

TEST_CASE("every shipped scene loads without a warning") {
    const auto rooms = scene_files(kScenes);
    const auto references = scene_files(kScenes / "reference");
    CHECK(rooms.size() >= 5);
    CHECK(references.size() >= 8);
    for (const auto& files : {rooms, references}) {
        for (const fs::path& file : files) {
            INFO(file);
            CHECK(aula::load_scene(file).warnings == std::vector<std::string>{});
        }
    }
}

TEST_CASE("the shipped rooms are closed around their sources and walks") {
    for (const fs::path& file : walked_rooms()) {
        INFO(file);
        const Scene scene = aula::load_scene(file).scene;
        const RayScene rays(scene);
        for (const auto& source : scene.sources) CHECK(escaping_share(rays, source.position) == 0);
        REQUIRE(scene.listener.path);
        for (const Trajectory::Keyframe& point : scene.listener.path->points) {
            CHECK(escaping_share(rays, point.pose.position) == 0);
        }
    }
}

TEST_CASE("the plugin's room is closed around its source and its listener") {
    const Scene scene = aula::load_scene(kScenes / "default.json").scene;
    const RayScene rays(scene);
    REQUIRE(scene.sources.size() == 1);
    CHECK(escaping_share(rays, scene.sources[0].position) == 0);
    CHECK(escaping_share(rays, scene.listener.pose.position) == 0);
}

TEST_CASE("the shipped walks pass through no wall or furniture, and look ahead") {
    for (const fs::path& file : walked_rooms()) {
        INFO(file);
        const Scene scene = aula::load_scene(file).scene;
        const RayScene rays(scene);
        REQUIRE(scene.listener.path);
        const auto& points = scene.listener.path->points;
        CHECK(points.back().time_s >= 8);
        CHECK(points.back().time_s <= 20);
        for (std::size_t i = 1; i < points.size(); ++i) {
            INFO("at " << points[i].time_s << " s");
            const Vec3 from = points[i - 1].pose.position;
            const Vec3 to = points[i].pose.position;
            CHECK(is_unobstructed(rays, from, to));
            CHECK(from.z >= 1.6F);
            CHECK(from.z <= 1.7F);
            const double speed_m_s = std::hypot(double{to.x - from.x}, double{to.y - from.y}) /
                                     (points[i].time_s - points[i - 1].time_s);
            CHECK(speed_m_s > 0.4);
            CHECK(speed_m_s < 1.6);
            // Yaw is the direction of the curve at a point; the step to the next one cuts the
            // curve.
            const double heading = std::atan2(double{to.y - from.y}, double{to.x - from.x});
            const double yaw =
                (double{points[i - 1].pose.yaw_rad} + double{points[i].pose.yaw_rad}) / 2;
            CHECK(turned_by_deg(yaw, heading) < 20);
        }
    }
}

TEST_CASE("a walk through the wall of the two rooms is detected") {
    const RayScene rays(aula::load_scene(kScenes / "two_rooms.json").scene);
    CHECK(is_unobstructed(rays, {7, 2.5F, 1.65F}, {5, 2.5F, 1.65F}));
    CHECK_FALSE(is_unobstructed(rays, {7, 3.5F, 1.65F}, {5, 3.5F, 1.65F}));
    CHECK(escaping_share(rays, {6.1F, 3.5F, 5}) > 0.4);
}

TEST_CASE("the walk of the two rooms leads from one room through the door into the other") {
    const Scene scene = aula::load_scene(kScenes / "two_rooms.json").scene;
    const RayScene rays(scene);
    const auto& points = scene.listener.path->points;
    CHECK(points.front().pose.position.x > 6.2F);
    CHECK(points.back().pose.position.x < 6);
    CHECK_FALSE(rays.visible(points.front().pose.position, scene.sources[0].position));
    CHECK(rays.visible(points.back().pose.position, scene.sources[0].position));
}

TEST_CASE("every shipped room plays sound files") {
    for (const fs::path& file : walked_rooms()) {
        INFO(file);
        for (const auto& source : aula::load_scene(file).scene.sources) {
            CHECK(source.signal == aula::Source::Signal::file);
        }
    }
}
