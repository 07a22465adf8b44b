#include "apps/aula/commands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "apps/aula/interrupt.h"
#include "apps/aula/outputs.h"
#include "apps/aula/terminal.h"
#include "apps/session/signals.h"
#include "audio/device.h"
#include "engine/error.h"
#include "engine/material_library.h"
#include "engine/patch_grid.h"
#include "engine/ray_scene.h"
#include "engine/room_acoustics.h"
#include "engine/room_survey.h"
#include "engine/scene_file.h"
#include "engine/worker_pool.h"

namespace aula {

namespace {

/// More patches than caches of a gigabyte hold are not counted.
constexpr double kMostPatches = 1e5;

/// Where rays get out of a room.
struct Leaks {
    double share = 0;                  ///< of the rays from inside
    std::vector<std::size_t> outside;  ///< which of the places, where a room is
};

/// What the triangles of a scene enclose.
struct Room {
    Leaks leaks;
    std::size_t patches = 0;      ///< that sound reaches
    float patch_size_m = 0;       ///< as wanted, or larger where there would be too many
    std::vector<double> area_m2;  ///< [material]
    std::size_t triangles = 0;
    Vec3 least{0};
    Vec3 most{0};
    double surface_m2 = 0;
    double volume_m3 = 0;
    bool closed = false;
    Bands mean_absorption{};
};

/// The listener, then the sources.
std::vector<Vec3> places(const Scene& scene) {
    std::vector<Vec3> points{scene.listener.pose_at(0).position};
    for (const Source& source : scene.sources) points.push_back(source.position_at(0));
    return points;
}

std::string who_is_at(const Scene& scene, std::size_t place) {
    return place == 0 ? "the listener" : "the source \"" + scene.sources[place - 1].name + "\"";
}

/// Looks round from the listener and the sources, then sends and reflects rays from those inside.
Leaks find_leaks(const RayScene& rays, const Scene& scene) {
    constexpr int kLooks = 1024;
    constexpr int kPaths = 4096;
    constexpr int kBounces = 32;
    // Who sees so much of the open stands outside, if somebody else sees less.
    constexpr double kOpen = 0.5;
    const auto escaping = [&](std::span<const Vec3> from, int paths, int bounces) {
        int escaped = 0;
        flood(rays, from, paths, bounces, 1,
              [&](int, const Ray&, const Hit& hit) { escaped += hit.any() ? 0 : 1; });
        return static_cast<double>(escaped) / paths;
    };
    const std::vector<Vec3> points = places(scene);
    std::vector<Vec3> inside;
    Leaks leaks;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (escaping({&points[i], 1}, kLooks, 1) < kOpen) {
            inside.push_back(points[i]);
        } else {
            leaks.outside.push_back(i);
        }
    }
    if (inside.empty()) {
        inside = points;
        leaks.outside.clear();
    }
    leaks.share = escaping(inside, kPaths, kBounces);
    return leaks;
}

Room measure_room(const Scene& scene) {
    const RayScene rays(scene);
    Room room;
    room.triangles = rays.triangle_count();
    if (room.triangles == 0) return room;
    room.least = room.most = rays.triangle(0).vertices[0];
    for (const auto& triangle : rays.triangles()) {
        for (const Vec3& vertex : triangle.vertices) {
            room.least = glm::min(room.least, vertex);
            room.most = glm::max(room.most, vertex);
        }
    }
    // Divergence theorem: the integral of x . n over a closed surface is three times its volume.
    // From the middle, where rounding is least.
    const glm::dvec3 middle = glm::dvec3(room.least + room.most) * 0.5;
    glm::dvec3 directed_m2{0};
    std::array<double, kBandCount> absorbing_m2{};
    for (const auto& triangle : rays.triangles()) {
        const glm::dvec3 a = glm::dvec3(triangle.vertices[0]) - middle;
        const glm::dvec3 b = glm::dvec3(triangle.vertices[1]) - middle;
        const glm::dvec3 c = glm::dvec3(triangle.vertices[2]) - middle;
        const glm::dvec3 area_m2 = 0.5 * glm::cross(b - a, c - a);
        directed_m2 += area_m2;
        room.volume_m3 += glm::dot(a, area_m2) / 3;
        room.surface_m2 += glm::length(area_m2);
        for (std::size_t band = 0; band < kBandCount; ++band)
            absorbing_m2[band] += glm::length(area_m2) *
                                  static_cast<double>(rays.material(triangle).absorption[band]);
    }
    room.area_m2.resize(scene.materials.size());
    for (const auto& triangle : rays.triangles())
        room.area_m2[triangle.material] += double{triangle.area_m2()};
    const std::vector<Vec3> inside = places(scene);
    room.leaks = find_leaks(rays, scene);
    WorkerPool workers(1);
    const PatchGrid grid(rays, scene.simulation.patch_size_m, inside, scene.simulation.seed,
                         workers, kMostPatches);
    room.patches = grid.reached();
    room.patch_size_m = grid.patch_size_m();
    room.volume_m3 = std::abs(room.volume_m3);
    // The directed areas of a closed surface cancel out.
    constexpr double kClosed = 1e-3;
    room.closed = glm::length(directed_m2) < kClosed * room.surface_m2;
    for (std::size_t band = 0; band < kBandCount; ++band)
        room.mean_absorption[band] = static_cast<float>(absorbing_m2[band] / room.surface_m2);
    return room;
}

/// Reverberation time after Sabine, in s, air absorption included.
Bands sabine_time_s(const Room& room, const Medium& medium) {
    const Bands attenuation_per_m = medium.attenuation_per_m();
    Bands time_s;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double absorbing_m2 =
            room.surface_m2 * static_cast<double>(room.mean_absorption[band]) +
            4 * static_cast<double>(attenuation_per_m[band]) * room.volume_m3;
        time_s[band] =
            static_cast<float>(24 * std::numbers::ln10 * room.volume_m3 /
                               (static_cast<double>(medium.speed_of_sound_m_s()) * absorbing_m2));
    }
    return time_s;
}

void print_row(const char* label, const Bands& values, int decimals) {
    std::printf("%-16s", label);
    for (const float value : values.value) {
        if (std::isfinite(value))
            std::printf("%8.*f", decimals, static_cast<double>(value));
        else
            std::printf("%8s", "-");
    }
    std::printf("\n");
}

void print_point(const char* label, const Vec3& p) {
    std::printf("%-15s %.2f, %.2f, %.2f m\n", label, static_cast<double>(p.x),
                static_cast<double>(p.y), static_cast<double>(p.z));
}

void print_band_names() {
    std::printf("%-16s", "Hz");
    for (const float centre : kBandCentres_hz) std::printf("%8.0f", static_cast<double>(centre));
    std::printf("\n");
}

std::string counted(std::size_t count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string describe(const Path& path) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "path of %.1f s%s", path.duration_s(),
                  path.loop ? ", repeated" : "");
    return text.data();
}

/// A warning for everything that options have put outside the bounds of the geometry.
std::vector<std::string> moved_outside(const Scene& before, const Scene& scene) {
    const Bounds bounds = geometry_bounds(scene.objects);
    std::vector<std::string> warnings;
    const auto check = [&](const std::string& who, const Vec3& was, const Vec3& is) {
        if (scene.objects.empty() || was == is || bounds.contains(is)) return;
        warnings.push_back(who + " is outside the bounds of the geometry");
    };
    check("--position: the listener", before.listener.pose_at(0).position,
          scene.listener.pose_at(0).position);
    for (std::size_t s = 0; s < scene.sources.size(); ++s)
        check("--source-position: the source \"" + scene.sources[s].name + "\"",
              before.sources[s].position_at(0), scene.sources[s].position_at(0));
    return warnings;
}

}  // namespace

void warn(const std::vector<std::string>& warnings, bool quiet) {
    if (quiet) return;
    for (const std::string& warning : warnings)
        std::fprintf(stderr, "aula: warning: %s\n", printable(warning).c_str());
}

int interrupted_status() { return 128 + interrupt_signal(); }

LoadedScene read_scene_file(const std::filesystem::path& file, const Arguments& arguments) {
    LoadedScene loaded = load_scene(file);
    warn(loaded.warnings, arguments.quiet);
    return loaded;
}

void change_scene(Scene& scene, const Arguments& arguments) {
    const Scene as_read = scene;
    for (const auto& change : arguments.scene_changes) change(scene);
    warn(moved_outside(as_read, scene), arguments.quiet);
}

Scene read_scene(const Arguments& arguments) {
    Scene scene = read_scene_file(arguments.scene, arguments).scene;
    change_scene(scene, arguments);
    check_outputs(arguments, scene);
    return scene;
}

int list_devices() {
    const std::vector<DeviceInfo> devices = list_output_devices();
    if (devices.empty()) {
        std::printf("no output devices\n");
        return 0;
    }
    std::size_t widest = 4;
    for (const DeviceInfo& device : devices) widest = std::max(widest, device.name.size());
    const int width = static_cast<int>(widest);
    std::printf("  index  %-*s  %-6s  channels  rate Hz  latency ms\n", width, "name", "system");
    for (const DeviceInfo& device : devices)
        std::printf("%c %5d  %-*s  %-6s  %8d  %7.0f  %10.1f\n", device.is_default ? '*' : ' ',
                    device.index, width, device.name.c_str(), device.host_api.c_str(),
                    device.output_channels, device.sample_rate_hz, 1000 * device.latency_s);
    std::printf("* the default\n");
    return 0;
}

/// Percent, one cell for each tenth: a glance at a curve.
void print_curve(const char* label, const Bands& shares) {
    std::printf("%s\n", label);
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const auto percent = std::lround(100 * static_cast<double>(shares[band]));
        const std::string bar(static_cast<std::size_t>(percent) * 40 / 100, '#');
        std::printf("  %5.0f Hz %3ld %% |%s\n", static_cast<double>(kBandCentres_hz[band]), percent,
                    bar.c_str());
    }
}

int show_material(const std::string& name) {
    const std::vector<LibraryMaterial> library = material_library();
    for (const LibraryMaterial& entry : library) {
        if (entry.material.name != name) continue;
        std::printf("%s\n%s\n", name.c_str(), entry.source.c_str());
        print_curve("absorption", entry.material.absorption);
        print_curve("scattering", entry.material.scattering);
        return 0;
    }
    throw Error("materials", "",
                "no material \"" + name + "\"; expected a name that aula materials list prints");
}

int list_materials(const Arguments& arguments) {
    if (arguments.material) return show_material(*arguments.material);
    print_band_names();
    for (const LibraryMaterial& entry : material_library()) {
        std::printf("\n%s\n", entry.material.name.c_str());
        print_row("  absorption", entry.material.absorption, 2);
        print_row("  scattering", entry.material.scattering, 2);
        std::printf("  %s\n", entry.source.c_str());
    }
    return 0;
}

int show_info(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    const Room room = measure_room(scene);
    std::printf("%-16s%zu\n", "triangles", room.triangles);
    if (room.triangles > 0) {
        print_point("from", room.least);
        print_point("to", room.most);
        std::printf("%-16s%.1f m2\n", "surface", room.surface_m2);
        std::printf("%-16s%.1f m3%s\n", "volume", room.volume_m3,
                    room.closed ? "" : " (the surface is not closed: of little meaning)");
    }
    for (const Source& source : scene.sources) {
        print_point(printable("source " + source.name).c_str(), source.position_at(0));
        if (source.path) std::printf("%-16s%s\n", "", describe(*source.path).c_str());
    }
    print_point("listener", scene.listener.pose_at(0).position);
    if (scene.listener.path) std::printf("%-16s%s\n", "", describe(*scene.listener.path).c_str());
    if (room.triangles == 0) return 0;
    std::printf("%-16s%zu of %.2f m\n", "patches", room.patches,
                static_cast<double>(room.patch_size_m));
    std::printf("%-16s%.2f %% of the rays get out%s\n", "leaks", 100 * room.leaks.share,
                room.leaks.share == 0 ? ": tight" : "");
    for (const std::size_t place : room.leaks.outside)
        std::printf("%-16s%s stands outside the room\n", "",
                    printable(who_is_at(scene, place)).c_str());
    std::printf("\n");
    for (std::size_t m = 0; m < room.area_m2.size(); ++m) {
        if (room.area_m2[m] == 0) continue;
        std::printf("%-24s%10.1f m2  %4.1f %%\n", printable(scene.materials[m].name).c_str(),
                    room.area_m2[m], 100 * room.area_m2[m] / room.surface_m2);
    }
    std::printf("\n");
    print_band_names();
    print_row("absorption", room.mean_absorption, 2);
    print_row("Sabine s", sabine_time_s(room, scene.medium), 2);
    print_row("Eyring s",
              eyring_time_s(room.volume_m3, room.surface_m2, room.mean_absorption,
                            scene.medium.attenuation_per_m(),
                            static_cast<double>(scene.medium.speed_of_sound_m_s())),
              2);
    return 0;
}

int check_scene(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    warn(warnings_of(read_signals(scene, arguments.session.sample_rate_hz)), arguments.quiet);
    const RayScene rays(scene);
    // What lets hardly any ray out is a room with a hole, rather than one that is open. Where
    // surfaces cross at an acute angle, a point a little off one may be behind the other: some rays
    // in 10000 find such places in a room full of things.
    constexpr double kHole = 0.3;
    constexpr double kCrossing = 0.001;
    const Leaks leaks = find_leaks(rays, scene);
    if (leaks.share > kCrossing && leaks.share < kHole)
        warn({arguments.scene.string() + ": " + std::to_string(std::lround(1e4 * leaks.share)) +
              " of 10000 rays get out: the room has a hole"},
             arguments.quiet);
    const Bounds bounds = geometry_bounds(scene.objects);
    for (const std::size_t place : leaks.outside) {
        // Outside the bounds, too, has been said already.
        if (!bounds.contains(places(scene)[place])) continue;
        warn({arguments.scene.string() + ": " + who_is_at(scene, place) +
              " stands outside the room"},
             arguments.quiet);
    }
    std::size_t triangles = 0;
    for (const Object& object : scene.objects) triangles += object.triangles.size();
    std::printf("%s: ok, %s, %s, %s\n", printable(arguments.scene.string()).c_str(),
                counted(triangles, "triangle").c_str(),
                counted(scene.materials.size(), "material").c_str(),
                counted(scene.sources.size(), "source").c_str());
    return 0;
}

}  // namespace aula
