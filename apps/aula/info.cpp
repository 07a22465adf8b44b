#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "apps/aula/commands.h"
#include "apps/aula/room_positions.h"
#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "apps/room/waves/wave_join.h"
#include "aula/engine/propagation.h"
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

std::string describe(const Trajectory& path) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "path of %.1f s%s", path.duration_s(),
                  path.loop ? ", repeated" : "");
    return text.data();
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

/// How low frequencies are computed.
void print_modes(const Scene& scene) {
    if (scene.simulation.waves_hz == 0) {
        std::printf("%-16soff: rays at all frequencies\n", "modes");
        return;
    }
    const WaveJoin waves(scene);
    for (const RoomWaves& room : waves.rooms())
        std::printf("%-16sbelow %.0f Hz, rays above%s\n", "modes",
                    WaveJoin::masks(room).crossover_hz,
                    waves.rooms().size() > 1
                        ? formatted("; in the room of %.0f m3", room.volume_m3()).c_str()
                        : "");
    for (const std::string& line : waves.warnings())
        std::printf("%s\n", printable_line(line).c_str());
}

}  // namespace

int show_info(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    const RayScene rays(scene);
    std::printf("%-16s%zu\n", "triangles", rays.triangle_count());
    const SortedPositions sorted = result_of(
        kMeasuring, arguments, [&] { return sort_positions(rays, initial_positions(scene)); });
    const RoomGeometry room = result_of(kMeasuring, arguments, [&] {
        return measure_room(rays, points_of(sorted.inside), kRoomSeed);
    });
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
        return escape_per_reflection(rays, points_of(sorted.inside), kRoomSeed);
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
    if (!room.volume_m3) {
        std::printf("\n");
        print_modes(scene);
        return 0;
    }
    std::printf("\n%-16s%.2f m\n", "mean free path", room.field.mean_free_path_m);
    print_band_names();
    print_row("absorption", room.field.mean_absorption, 2);
    print_row("Sabine s", sabine_time_s(room.field, scene.medium), 2);
    const Bands eyring_s = reverberation_time_s(room.field, scene.medium);
    print_row("Eyring s", eyring_s, 2);
    const double middle_s = double{eyring_s[3] + eyring_s[4]} / 2;
    if (std::isfinite(middle_s))
        std::printf("%-16s%.0f Hz by Eyring's time; single modes are heard below\n", "Schroeder",
                    schroeder_frequency_hz(middle_s, *room.volume_m3));
    print_modes(scene);
    return 0;
}

}  // namespace aula
