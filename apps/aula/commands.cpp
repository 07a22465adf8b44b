#include "apps/aula/commands.h"

#include <cstdio>

#include "apps/aula/outputs.h"
#include "apps/aula/room_positions.h"
#include "apps/aula/terminal/interrupt.h"
#include "apps/output/printable.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

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
        check((scene.sources[s].from_listener ? "--position: the source \""
                                              : "--source-position: the source \"") +
                  scene.sources[s].name + "\"",
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

}  // namespace aula
