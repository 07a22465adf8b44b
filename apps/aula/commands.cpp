#include "apps/aula/commands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <map>

#include "apps/aula/interrupt.h"
#include "apps/aula/outputs.h"
#include "apps/aula/terminal.h"
#include "apps/session/base/formatted.h"
#include "apps/session/base/printable.h"
#include "apps/session/frames/signals.h"
#include "aula/devices/device.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/estimate/patch_propagation.h"
#include "engine/patches/patch_grid.h"
#include "engine/rays/nudge_off_surface.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/room_survey.h"
#include "engine/scene/scene_positions.h"

namespace aula {

namespace {

/// Upper limit of the patch count: more than the caches hold in 1 GB.
constexpr double kMaxPatches = 1e5;

constexpr std::uint64_t kSeed = 1;

constexpr const char* kMeasuring = "measuring the room";
constexpr const char* kListener = "the listener";

/// A position of the listener or of a source.
struct NamedPosition {
    std::string name;
    Vec3 position{0};
    std::optional<double> time_s;  ///< on the path; empty at rest or at its start
};

/// Initial positions of the listener, then of the sources.
std::vector<NamedPosition> initial_positions(const Scene& scene) {
    std::vector<NamedPosition> positions{{kListener, scene.listener.pose_at(0).position, {}}};
    for (const Source& source : scene.sources)
        positions.push_back({"the source \"" + source.name + "\"", source.position_at(0), {}});
    return positions;
}

/// Adds positions along a path, 0.5 m apart, or farther apart on paths longer than 128 m.
void add_along(const std::string& name, const Trajectory& path,
               std::vector<NamedPosition>& positions) {
    constexpr double kMaxPositions = 256;
    double length_m = 0;
    const auto step_m = [&](std::size_t i) {
        return double{
            glm::distance(path.points[i - 1].pose.position, path.points[i].pose.position)};
    };
    for (std::size_t i = 1; i < path.points.size(); ++i) length_m += step_m(i);
    const double apart_m = std::max(0.5, length_m / kMaxPositions);
    double next_m = apart_m;
    double passed_m = 0;
    for (std::size_t i = 1; i < path.points.size(); ++i) {
        for (; next_m <= passed_m + step_m(i); next_m += apart_m) {
            const double share = (next_m - passed_m) / step_m(i);
            const double time_s =
                std::lerp(path.points[i - 1].time_s, path.points[i].time_s, share);
            positions.push_back({name, path.at(time_s).position, time_s});
        }
        passed_m += step_m(i);
    }
}

/// The initial positions and positions along all paths.
std::vector<NamedPosition> positions_along_paths(const Scene& scene) {
    std::vector<NamedPosition> positions = initial_positions(scene);
    if (scene.listener.path) add_along(kListener, *scene.listener.path, positions);
    for (const Source& source : scene.sources)
        if (source.path) add_along("the source \"" + source.name + "\"", *source.path, positions);
    return positions;
}

std::vector<Vec3> points_of(const std::vector<NamedPosition>& positions) {
    std::vector<Vec3> points;
    for (const NamedPosition& item : positions) points.push_back(item.position);
    return points;
}

/// Positions outside and inside the room.
struct SortedPositions {
    std::vector<NamedPosition> outside;
    std::vector<NamedPosition> inside;
};

/// The result of `work`. If it takes long, a status line on the terminal shows `what`.
template <typename Work>
auto result_of(const std::string& what, const Arguments& arguments, const Work& work) {
    const TaskLine line(what, !arguments.quiet);
    return work();
}

SortedPositions sort_positions(const RayScene& rays, std::vector<NamedPosition> positions) {
    // As the propagation does: half of the walks from a point on a surface would leave the room.
    for (NamedPosition& item : positions) item.position = nudge_off_surface(rays, item.position);
    const std::vector<char> outside = outside_room(rays, points_of(positions), kSeed);
    SortedPositions sorted;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        (outside[i] ? sorted.outside : sorted.inside).push_back(positions[i]);
    }
    return sorted;
}

/// Largest relative decrease of Sabine's reverberation time over the bands, 0..1, against the room
/// without openings, if the share `escape` of the reflections leaves it.
double reverberation_decrease(const RoomGeometry& room, double escape, const Medium& medium) {
    RoomSurvey tight = room.field;
    RoomSurvey leaky = room.field;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double of_faces = std::max(
            0.0, (double{room.field.mean_absorption[b]} - room.open_share) / (1 - room.open_share));
        tight.mean_absorption[b] = static_cast<float>(of_faces);
        leaky.mean_absorption[b] = static_cast<float>(escape + (1 - escape) * of_faces);
    }
    const Bands tight_s = sabine_time_s(tight, medium);
    const Bands leaky_s = sabine_time_s(leaky, medium);
    double largest = 0;
    for (std::size_t b = 0; b < kBandCount; ++b)
        if (std::isfinite(tight_s[b]))
            largest = std::max(largest, 1 - double{leaky_s[b] / tight_s[b]});
    return largest;
}

void print_row(const char* label, const Bands& values, int decimals) {
    std::printf("%-16s", label);
    for (const float value : values.value) {
        if (std::isfinite(value))
            std::printf("%s", fixed_text(static_cast<double>(value), decimals, 8).c_str());
        else
            std::printf("%8s", "-");
    }
    std::printf("\n");
}

/// The level of a directivity to the front in each band.
void print_on_axis(const Directivity& directivity) {
    std::printf("%-16son axis", "");
    for (const float level_db : directivity.on_axis_db().value)
        std::printf(" %s", fixed_text(static_cast<double>(level_db), 1).c_str());
    std::printf(" dB, 63 Hz to 8 kHz\n");
}

void print_point(const char* label, const Vec3& p) {
    const auto coordinate = [](float x) { return fixed_text(static_cast<double>(x), 2); };
    std::printf("%-15s %s, %s, %s m\n", label, coordinate(p.x).c_str(), coordinate(p.y).c_str(),
                coordinate(p.z).c_str());
}

void print_band_names() {
    std::printf("%-16s", "Hz");
    for (const float centre : kBandCentres_hz) std::printf("%8.0f", static_cast<double>(centre));
    std::printf("\n");
}

/// Commands without sound do not need the sounds of a scene.
SignalFiles signal_files(const Arguments& arguments) {
    using Command = Arguments::Command;
    switch (arguments.command) {
        case Command::info:
        case Command::measure:
        case Command::map:
        case Command::report:
            return SignalFiles::optional;
        default:
            return SignalFiles::required;
    }
}

std::string describe(const Trajectory& path) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "path of %.1f s%s", path.duration_s(),
                  path.loop ? ", repeated" : "");
    return text.data();
}

/// Warnings for a listener and sources that options place outside the bounds of the geometry.
std::vector<std::string> moved_outside(const Scene& before, const Scene& scene) {
    const Bounds bounds = geometry_bounds(scene.objects);
    std::vector<std::string> warnings;
    const auto check = [&](const std::string& name, const Vec3& from, const Vec3& to) {
        if (scene.objects.empty() || from == to || bounds.contains(to)) return;
        warnings.push_back(name + " is outside the bounds of the geometry");
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
        std::fprintf(stderr, "aula: warning: %s\n", printable_line(warning).c_str());
}

int interrupted_status() { return 128 + interrupt_signal(); }

LoadedScene read_scene_file(const std::filesystem::path& file, const Arguments& arguments) {
    LoadedScene loaded = result_of("reading " + printable_line(file.filename().string()), arguments,
                                   [&] { return load_scene(file, signal_files(arguments)); });
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
    if (devices.empty()) throw NoAudioDevice();
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

/// The direct sound at the initial positions, and the length of the responses.
struct DirectPaths {
    FrameStatistics statistics;
    double length_s = 0;
};

DirectPaths direct_paths(const Scene& scene) {
    Simulation simulation = scene.simulation;
    simulation.estimator = Estimator::pt;  // no patches
    simulation.rays = 1;
    simulation.specular_order = 0;
    Propagation propagation(scene, simulation);
    FrameInput input{.sources = {}, .listeners = {scene.listener.pose_at(0).position}};
    for (const Source& source : scene.sources) input.sources.push_back(source.position_at(0));
    propagation.step(input);
    return {propagation.statistics(), propagation.response_length_s()};
}

int show_info(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    const RayScene rays(scene);
    std::printf("%-16s%zu\n", "triangles", rays.triangle_count());
    const SortedPositions sorted = result_of(
        kMeasuring, arguments, [&] { return sort_positions(rays, initial_positions(scene)); });
    const RoomGeometry room = result_of(
        kMeasuring, arguments, [&] { return measure_room(rays, points_of(sorted.inside), kSeed); });
    if (rays.triangle_count() > 0) {
        const Bounds bounds = geometry_bounds(scene.objects);
        print_point("from", bounds.min);
        print_point("to", bounds.max);
        std::printf("%-16s%.1f m2 that sound reaches\n", "surface", room.surface_m2);
        if (room.volume_m3) {
            std::printf("%-16s%.1f m3", "volume", *room.volume_m3);
            if (room.open_share > 0) std::printf(", openings %.2g %%", 100 * room.open_share);
            std::printf("\n");
        } else {
            std::printf("%-16snot closed\n", "volume");
        }
    }
    for (const Source& source : scene.sources) {
        print_point(printable_line("source " + source.name).c_str(), source.position_at(0));
        if (source.path) std::printf("%-16s%s\n", "", describe(*source.path).c_str());
        if (!source.directivity.is_omnidirectional()) print_on_axis(source.directivity);
    }
    print_point("listener", scene.listener.pose_at(0).position);
    if (scene.listener.path) std::printf("%-16s%s\n", "", describe(*scene.listener.path).c_str());
    if (rays.triangle_count() == 0) return 0;
    const DirectPaths direct =
        result_of("finding edges and paths", arguments, [&] { return direct_paths(scene); });
    const double max_patches =
        std::min(kMaxPatches,
                 PatchPropagation::max_rows(scene.simulation.memory_mb * 1e6,
                                            TimeBins(direct.length_s), scene.sources.size(), 1));
    const PatchGrid::Extent patches = result_of("counting patches", arguments, [&] {
        return PatchGrid::extent(rays, scene.simulation.patch_size_m,
                                 nudge_off_surfaces(rays, scene_positions(scene)),
                                 scene.simulation.seed, max_patches);
    });
    std::printf("%-16s%zu of %.2f m\n", "patches", patches.reached,
                static_cast<double>(patches.patch_size_m));
    std::printf("%-16s%zu that diffract sound\n", "edges", direct.statistics.edges);
    std::printf("%-16s%zu bent, %zu through walls, from all sources\n", "direct paths",
                direct.statistics.bent_paths, direct.statistics.wall_paths);
    const double escape = result_of(kMeasuring, arguments, [&] {
        return escape_per_reflection(rays, points_of(sorted.inside), kSeed);
    });
    if (escape == 0) {
        std::printf("%-16snone: tight\n", "leaks");
    } else {
        std::printf("%-16s%.2g %% of the reflections\n", "leaks", 100 * escape);
    }
    for (const NamedPosition& item : sorted.outside)
        std::printf("%-16s%s is outside the room\n", "", printable_line(item.name).c_str());
    std::printf("\n");
    for (std::size_t m = 0; m < room.area_m2.size(); ++m) {
        if (room.area_m2[m] == 0) continue;
        std::printf("%-24s%10.1f m2  %4.1f %%\n", printable_line(scene.materials[m].name).c_str(),
                    room.area_m2[m], 100 * room.area_m2[m] / room.surface_m2);
    }
    if (!room.volume_m3) return 0;
    std::printf("\n%-16s%.2f m\n", "mean free path", room.field.mean_free_path_m);
    print_band_names();
    print_row("absorption", room.field.mean_absorption, 2);
    print_row("Sabine s", sabine_time_s(room.field, scene.medium), 2);
    print_row("Eyring s", reverberation_time_s(room.field, scene.medium), 2);
    return 0;
}

/// Reads the signals of all sources. Throws SceneErrors: one message for each that fails.
void check_signals(const Scene& scene, const Arguments& arguments) {
    SharedSignals files(scene, arguments.session.sample_rate_hz);
    SignalSet signals;
    std::vector<std::string> errors;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        try {
            signals.push_back(
                result_of("reading the sound of " + printable_line(scene.sources[s].name),
                          arguments, [&] { return files.read(s); }));
        } catch (const InputError& error) {
            // Sources can play the same file.
            if (std::find(errors.begin(), errors.end(), error.what()) == errors.end())
                errors.emplace_back(error.what());
        }
    }
    if (!errors.empty()) throw SceneErrors(std::move(errors));
    warn(warnings_of(signals), arguments.quiet);
}

/// "after 1.5 s, at (1, 2, 3)", or the point alone for an initial position.
std::string place_text(const NamedPosition& item) {
    const Vec3& p = item.position;
    return (item.time_s ? formatted(" after %.1f s", *item.time_s) : "") +
           formatted(", at (%g, %g, %g)", double{p.x}, double{p.y}, double{p.z});
}

/// Warns of the listener and sources outside the room, once each.
void check_positions(const Scene& scene, const SortedPositions& sorted,
                     const Arguments& arguments) {
    const Bounds bounds = geometry_bounds(scene.objects);
    std::vector<std::string> reported;
    for (const NamedPosition& item : sorted.outside) {
        if (std::find(reported.begin(), reported.end(), item.name) != reported.end()) continue;
        reported.push_back(item.name);
        // Reading the scene has warned of positions outside the bounds.
        if (!bounds.contains(item.position)) continue;
        warn({arguments.scene.string() + ": " + item.name + " is outside the room" +
              place_text(item)},
             arguments.quiet);
    }
}

/// Warns of a source, or the listener, whose `places` sound cannot reach from any of `others`,
/// wherever the movable objects are. Returns false if that is so for all places.
bool check_connection(const RayScene& rays, const std::vector<NamedPosition>& places,
                      const std::vector<Vec3>& others, const Arguments& arguments) {
    const std::vector<char> reached = result_of(kMeasuring, arguments, [&] {
        return connected(rays, others, points_of(places), kSeed, MovableObjects::are_passed);
    });
    const auto cut_off = std::find(reached.begin(), reached.end(), 0);
    if (std::find(reached.begin(), reached.end(), 1) == reached.end()) return false;
    if (cut_off == reached.end()) return true;
    const NamedPosition& first = places[static_cast<std::size_t>(cut_off - reached.begin())];
    warn({arguments.scene.string() + ": " + first.name + " is inside a closed body" +
          place_text(first) + ": no sound passes its surfaces; lead the path around it"},
         arguments.quiet);
    return true;
}

/// Warns of sources that sound cannot leave for the listener, wherever both are on their paths, and
/// of parts of the paths that are inside closed bodies. Of positions outside the room
/// check_positions() warns.
void check_audibility(const RayScene& rays, const SortedPositions& sorted,
                      const Arguments& arguments) {
    std::map<std::string, std::vector<NamedPosition>> places;
    for (const NamedPosition& item : sorted.inside) places[item.name].push_back(item);
    const std::vector<NamedPosition> listener = places[kListener];
    places.erase(kListener);
    if (listener.empty()) return;
    std::vector<Vec3> audible;
    for (const auto& [name, source] : places) {
        if (check_connection(rays, source, points_of(listener), arguments)) {
            for (const NamedPosition& item : source) audible.push_back(item.position);
        } else {
            warn({arguments.scene.string() + ": " + name +
                  " is never audible: closed surfaces separate it from the listener"},
                 arguments.quiet);
        }
    }
    if (!audible.empty()) check_connection(rays, listener, audible, arguments);
}

/// Reports the share of reflections that escape and their effect on the reverberation time.
void check_leaks(const Scene& scene, const RayScene& rays, const SortedPositions& sorted,
                 const Arguments& arguments) {
    // Relative error of the reverberation time; the just noticeable difference is 5 %.
    constexpr double kHarmless = 0.01;
    // Share of escaping reflections above which faces are missing: more than a slit.
    constexpr double kHoles = 0.01;
    // Share above which there is no room, but walls in the open.
    constexpr double kOpen = 0.5;
    const double escape = result_of(kMeasuring, arguments, [&] {
        return escape_per_reflection(rays, points_of(sorted.inside), kSeed);
    });
    if (escape == 0 || escape > kOpen) return;
    const double shorter = result_of(kMeasuring, arguments, [&] {
        return reverberation_decrease(measure_room(rays, points_of(sorted.inside), kSeed), escape,
                                      scene.medium);
    });
    const std::string line =
        arguments.scene.string() +
        formatted(": %.2g %% of the reflections escape, the reverberation time is %.2g %% shorter",
                  100 * escape, 100 * shorter);
    if (shorter > kHarmless) {
        warn({line + (escape > kHoles ? ": the room is open, or faces of its mesh are missing"
                                      : ": the room has a hole")},
             arguments.quiet);
    } else {
        std::printf("%s: harmless\n", line.c_str());
    }
}

int check_scene(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    check_signals(scene, arguments);
    const RayScene rays(scene);
    const SortedPositions sorted = result_of(
        kMeasuring, arguments, [&] { return sort_positions(rays, positions_along_paths(scene)); });
    check_leaks(scene, rays, sorted, arguments);
    check_positions(scene, sorted, arguments);
    check_audibility(rays, sorted, arguments);
    std::size_t triangles = 0;
    for (const Object& object : scene.objects) triangles += object.triangles.size();
    std::printf("%s: ok, %s, %s, %s\n", printable_line(arguments.scene.string()).c_str(),
                counted(triangles, "triangle").c_str(),
                counted(scene.materials.size(), "material").c_str(),
                counted(scene.sources.size(), "source").c_str());
    return 0;
}

}  // namespace aula
