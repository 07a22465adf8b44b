#include "apps/bench/propagation/diffraction.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>

#include "apps/bench/propagation/source_positions.h"
#include "aula/engine/propagation.h"
#include "aula/exception.h"
#include "engine/base/sampling.h"
#include "engine/base/stopwatch.h"
#include "engine/direct/direct_sound.h"
#include "engine/edges/scene_edges.h"
#include "engine/mesh/mesh_import.h"
#include "engine/rays/ray_scene.h"

namespace aula::bench {

namespace {

constexpr int kDiffractionFrames = 60;
constexpr double kPace_m_s = 1.4;
constexpr float kEar_m = 1.6F;
constexpr double kBeforeMovement_s = 0.25;
constexpr std::size_t kLoadedTriangles = 100'000;
constexpr float kBetweenCopies_m = 20;  // more than the paths over edges reach

/// The listener in a frame: on its path, else a walk of up to 1 m towards the first source.
Vec3 listener_at(const Scene& scene, double time_s) {
    if (scene.listener.path) return scene.listener.pose_at(time_s).position;
    const Vec3 from = scene.listener.pose_at(0).position;
    const Vec3 offset = scene.sources[0].position_at(0) - from;
    const float distance_m = glm::length(offset);
    const float longest_m = std::min(1.0F, distance_m / 2);
    const auto walked_m = static_cast<float>(std::fmod(kPace_m_s * time_s, double{2 * longest_m}));
    return from + offset / distance_m * std::min(walked_m, 2 * longest_m - walked_m);
}

/// The time of the first frame: shortly before the first object moves, if one does.
double begin_s(const Scene& scene) {
    std::optional<double> movement_s;
    for (const Object& object : scene.objects) {
        if (!object.path) continue;
        const auto& points = object.path->points;
        for (std::size_t i = 1; i < points.size(); ++i) {
            const Pose& last = points[i - 1].pose;
            const Pose& next = points[i].pose;
            if (next.position == last.position && next.rotation() == last.rotation()) continue;
            const double from_s = points[i - 1].time_s;
            movement_s = std::min(movement_s.value_or(from_s), from_s);
        }
    }
    return std::max(0.0, movement_s.value_or(0) - kBeforeMovement_s);
}

/// One object of copies of all objects, in rows of a square.
Object copies_of(const Scene& scene, std::size_t triangles) {
    Object one;
    Bounds bounds;
    for (const Object& object : scene.objects) {
        const auto first = static_cast<std::uint32_t>(one.vertices.size());
        for (const Vec3& v : object.world_vertices(0)) one.vertices.push_back(v);
        for (const auto& [a, b, c] : object.triangles) {
            one.triangles.push_back({first + a, first + b, first + c});
        }
    }
    bounds.add(one.vertices);
    const std::size_t count = (triangles + one.triangles.size() - 1) / one.triangles.size();
    const auto in_row = static_cast<std::size_t>(std::ceil(std::sqrt(count)));
    const Vec3 distance_m = bounds.max - bounds.min + Vec3(kBetweenCopies_m);
    Object all;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3 offset = distance_m * Vec3(i % in_row, i / in_row, 0);
        const auto first = static_cast<std::uint32_t>(all.vertices.size());
        for (const Vec3& v : one.vertices) all.vertices.push_back(v + offset);
        for (const auto& [a, b, c] : one.triangles) {
            all.triangles.push_back({first + a, first + b, first + c});
        }
    }
    all.triangle_materials.assign(all.triangles.size(), 0);
    return all;
}

Row measure_row(const Subject& subject, const std::vector<Vec3>& sources) {
    Scene scene = subject.scene;
    scene.sources.assign(sources.size(), scene.sources[0]);
    for (std::size_t s = 0; s < sources.size(); ++s) {
        scene.sources[s].position = sources[s];
        scene.sources[s].path.reset();
    }
    const Simulation simulation =
        subject.simulation(Estimator::patch, scene.simulation.ray_count());
    Stopwatch watch;
    Propagation propagation(scene, simulation);
    const double load_s = watch.lap_s();
    const RayScene rays(scene);
    watch.lap_s();
    const SceneEdges edges(rays);
    const double edges_s = watch.lap_s();

    const double first_s = begin_s(subject.scene);
    double frames_s = 0;
    double diffraction_s = 0;
    double longest_s = 0;
    double paths = 0;
    for (int f = 0; f < kDiffractionFrames; ++f) {
        const double time_s = first_s + f / double{simulation.frame_rate_hz};
        const FrameInput input{time_s, sources, {listener_at(subject.scene, time_s)}};
        watch.lap_s();
        propagation.step(input);
        frames_s += watch.lap_s();
        const FrameStatistics& statistics = propagation.statistics();
        diffraction_s += statistics.diffraction_s;
        longest_s = std::max(longest_s, statistics.diffraction_s);
        paths += static_cast<double>(statistics.bent_paths);
    }
    Row row;
    row.figures = {{"bench", "diffraction"},
                   {"scene", subject.name},
                   {"basis", "rays"},
                   {"sources", static_cast<std::int64_t>(sources.size())},
                   {"rays", std::int64_t{scene.simulation.ray_count()}},
                   {"triangles", static_cast<std::int64_t>(rays.triangle_count())},
                   {"edges", static_cast<std::int64_t>(edges.count())},
                   {"bent_paths", paths / kDiffractionFrames},
                   {"load_s", load_s},
                   {"edges_s", edges_s},
                   {"frame_ms", frames_s / kDiffractionFrames * 1e3},
                   {"diffraction_ms", diffraction_s / kDiffractionFrames * 1e3},
                   {"longest_ms", longest_s * 1e3},
                   {"diffraction_share", diffraction_s / frames_s}};
    return row;
}

}  // namespace

std::vector<Row> measure_diffraction(const Subject& subject, const Settings& settings) {
    std::vector<Row> rows;
    for (const int count : {1, 8}) {
        settings.progress("diffraction: " + std::to_string(count) + " sources");
        rows.push_back(measure_row(subject, source_positions(subject.scene, count)));
    }
    return rows;
}

const std::vector<Column>& diffraction_columns() {
    static const std::vector<Column> columns =
        columns_of({"sources", "rays", "triangles", "edges", "bent_paths", "load_s", "edges_s",
                    "frame_ms", "diffraction_ms", "longest_ms", "diffraction_share"});
    return columns;
}

std::vector<Row> measure_edge_search(const Subject& subject, const Settings& settings) {
    settings.progress("diffraction: edges of many triangles");
    Scene scene = subject.scene;
    scene.objects = {copies_of(subject.scene, kLoadedTriangles)};
    Stopwatch watch;
    const RayScene rays(scene);
    const double rays_s = watch.lap_s();
    const DirectSound direct(rays, scene.medium.speed_of_sound_m_s(),
                             scene.simulation.diffraction_order);
    const double edges_s = watch.lap_s();
    Row row;
    row.figures = {{"bench", "edge_search"},
                   {"scene", subject.name},
                   {"triangles", static_cast<std::int64_t>(rays.triangle_count())},
                   {"edges", static_cast<std::int64_t>(direct.edges().count())},
                   {"ray_scene_s", rays_s},
                   {"edges_s", edges_s}};
    return {row};
}

const std::vector<Column>& edge_search_columns() {
    static const std::vector<Column> columns =
        columns_of({"triangles", "edges", "ray_scene_s", "edges_s"});
    return columns;
}

Subject level_of(const std::filesystem::path& mesh_file, const Settings& settings) {
    ImportedMesh mesh = import_mesh(mesh_file);
    for (Vec3& v : mesh.vertices) v = Vec3(v.x, -v.z, v.y);
    Object level;
    level.vertices = std::move(mesh.vertices);
    level.triangles = std::move(mesh.triangles);
    level.triangle_materials.assign(level.triangles.size(), 0);
    Scene scene;
    scene.objects.push_back(std::move(level));
    scene.materials = {{"wall", Bands::filled(0.1F), Bands::filled(0.3F)}};
    scene.sources.emplace_back();

    // The listener is above a floor and under a ceiling, and so is the source, 5 to 15 m away.
    const RayScene rays(scene);
    RandomStream random(derive_seed(1, 0x1e7e1));
    std::vector<Vec3> places;
    constexpr int kTries = 100'000;
    for (int i = 0; i < kTries && places.size() < 2; ++i) {
        const auto t = static_cast<std::uint32_t>(random.bits() % rays.triangle_count());
        const RayScene::Triangle& floor = rays.triangle(t);
        if (!(floor.normal.z > 0.9F) || floor.area_m2() < 0.5F) continue;
        const Vec3 ear =
            (floor.vertices[0] + floor.vertices[1] + floor.vertices[2]) / 3.0F + Vec3(0, 0, kEar_m);
        const bool is_inside = !rays.visible(ear, ear + Vec3(0, 0, 20)) &&
                               rays.visible(ear, ear - Vec3(0, 0, kEar_m - 0.1F));
        if (!is_inside) continue;
        if (places.size() == 1) {
            const float distance_m = glm::distance(places[0], ear);
            if (distance_m < 5 || distance_m > 15) continue;
        }
        places.push_back(ear);
    }
    if (places.size() < 2) {
        throw InputError(mesh_file.string(), "mesh",
                         "has no two places on a floor; expected a level in metres with y up");
    }
    scene.listener.pose.position = places[0];
    scene.sources[0].position = places[1];
    return {mesh_file.filename().string(), scene, settings};
}

}  // namespace aula::bench
