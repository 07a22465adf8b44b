#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <system_error>

#include "apps/aula/commands.h"
#include "apps/aula/outputs.h"
#include "apps/aula/progress_bar.h"
#include "apps/dataset/plan/planned_scene.h"
#include "apps/documents/map_measurement.h"
#include "apps/documents/parameter_map.h"
#include "apps/documents/room_report.h"
#include "apps/session/base/output_file.h"
#include "aula/exception.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

/// Throws InputError if files cannot be written to a folder, which need not exist yet.
void check_folder(const fs::path& folder) {
    std::error_code error;
    fs::path existing = folder;
    while (!existing.empty() && !fs::exists(existing, error)) existing = existing.parent_path();
    if (existing.empty()) existing = ".";
    const char* const expected = "; expected the name of a folder to write to";
    if (!fs::is_directory(existing, error))
        throw InputError(folder.string(), "",
                         existing.string() + " is not a folder" + std::string(expected));
    if (access(existing.c_str(), W_OK | X_OK) != 0)
        throw InputError(folder.string(), "",
                         "cannot be written, " + std::generic_category().message(errno) + expected);
}

void write_file(const fs::path& file, const std::string& content) {
    OutputFile out(file);
    out.write(content);
    out.commit();
}

/// New files in a folder. The destructor removes them, and new folders, unless they are complete.
class NewFiles {
 public:
    /// Throws Failure if the folder cannot be created.
    explicit NewFiles(fs::path folder) : folder_(std::move(folder)) {
        std::error_code error;
        for (fs::path f = folder_; !f.empty() && !fs::exists(f, error); f = f.parent_path())
            folders_.push_back(f);
        fs::create_directories(folder_, error);
        if (error) throw Failure(folder_.string() + ": cannot create: " + error.message());
    }
    ~NewFiles() {
        std::error_code ignored;
        for (const fs::path& file : files_) fs::remove(file, ignored);
        for (const fs::path& folder : folders_) fs::remove(folder, ignored);
    }
    NewFiles(const NewFiles&) = delete;
    NewFiles& operator=(const NewFiles&) = delete;

    /// Writes a file; a former one of that name is replaced.
    void write(const fs::path& file, const std::string& content) {
        std::error_code ignored;
        if (!fs::exists(file, ignored)) files_.push_back(file);
        write_file(file, content);
    }

    void complete() {
        files_.clear();
        folders_.clear();
    }

 private:
    fs::path folder_;
    std::vector<fs::path> folders_;  ///< new ones, innermost first
    std::vector<fs::path> files_;
};

/// Writes a picture and a table of each parameter of each source. Returns false after a signal.
bool write_maps(const Arguments& arguments, const ParameterMap& map, const Scene& scene) {
    NewFiles files(arguments.out);
    ProgressBar bar("drawing the maps", arguments.quiet);
    const auto parameters = mapped_parameters(arguments.map_interaural);
    const double count =
        static_cast<double>(scene.sources.size()) * static_cast<double>(parameters.size());
    double done = 0;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        for (const std::size_t parameter : parameters) {
            if (!bar(done++ / count)) return false;
            const auto [table, picture] = map_files(arguments, scene, s, parameter);
            files.write(table, map_csv(map, s, parameter));
            files.write(picture, map_png(map, s, parameter, arguments.scene.stem().string()));
        }
    }
    files.complete();
    return true;
}

/// Warnings for all receivers: how many are not audible or have larger errors than wanted.
std::vector<std::string> warnings_of(const Measurement& measurement) {
    std::vector<std::string> warnings;
    const std::size_t receivers = measurement.receivers.size();
    for (std::size_t s = 0; s < measurement.sources.size(); ++s) {
        const auto first = measurement.audible.begin() + static_cast<std::ptrdiff_t>(s * receivers);
        const auto audible = static_cast<std::size_t>(
            std::count(first, first + static_cast<std::ptrdiff_t>(receivers), 1));
        if (audible < receivers)
            warnings.push_back("source \"" + measurement.sources[s].name + "\" is not audible at " +
                               std::to_string(receivers - audible) + " of " +
                               std::to_string(receivers) + " receivers");
    }
    const auto silent = static_cast<std::size_t>(
        std::count(measurement.audible.begin(), measurement.audible.end(), 0));
    if (measurement.warnings.size() > silent)
        warnings.push_back("standard errors after " + std::to_string(measurement.frames) +
                           " frames are larger than wanted at " +
                           std::to_string(measurement.warnings.size() - silent) + " of " +
                           std::to_string(measurement.audible.size()) +
                           " pairs of source and receiver");
    return warnings;
}

/// The geometry of the rooms of the sources and receivers.
RoomGeometry geometry_of(const Measurement& measurement, const RayScene& rays) {
    std::vector<Vec3> positions;
    for (const Source& source : measurement.sources) positions.push_back(source.position_at(0));
    for (const Pose& receiver : measurement.receivers) positions.push_back(receiver.position);
    const std::vector<char> outside = outside_room(rays, positions, measurement.simulation.seed);
    std::vector<Vec3> inside;
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (!outside[i]) inside.push_back(positions[i]);
    return measure_room(rays, inside, measurement.simulation.seed);
}

}  // namespace

int map_room(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    check_folder(arguments.out);
    const RayScene rays(scene);
    const ReceiverGrid grid = [&] {
        const TaskLine line("finding receivers in the room", !arguments.quiet);
        return receiver_grid(scene, rays, arguments.map_height_m, arguments.map_spacing_m);
    }();
    const FloorPlan plan = floor_plan(rays, grid.height_m);
    const auto measurement = [&] {
        ProgressBar bar("measuring at " + std::to_string(grid.receivers.size()) + " receivers",
                        arguments.quiet);
        return measure_map(scene, grid, arguments.frames, arguments.map_interaural, std::ref(bar));
    }();
    if (!measurement) return interrupted_status();
    warn(warnings_of(*measurement), arguments.quiet);
    return write_maps(arguments, {grid, plan, *measurement}, scene) ? 0 : interrupted_status();
}

int report_room(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    OutputFile file(arguments.html);
    std::vector<std::string> names;
    std::vector<Pose> receivers;
    for (const NamedReceiver& receiver : arguments.receivers) {
        names.push_back(receiver.name);
        receivers.push_back({.position = receiver.position});
    }
    if (receivers.empty()) {
        names.emplace_back("listener");
        receivers.push_back(scene.listener.pose_at(0));
    }
    const auto measurement = [&] {
        ProgressBar bar("measuring", arguments.quiet);
        return measure(scene, scene.sources, receivers,
                       {.frames = arguments.frames, .interaural = true, .progress = std::ref(bar)});
    }();
    if (!measurement) return interrupted_status();
    warn(measurement->warnings, arguments.quiet);
    const TaskLine line("writing the report", !arguments.quiet);
    const RayScene rays(scene);
    const float height_m = receivers[0].position.z;
    file.write(report_html({.title = arguments.scene.stem().string(),
                            .program = "aula " AULA_VERSION,
                            .scene_hash = scene_hash(scene),
                            .scene = scene,
                            .measurement = *measurement,
                            .receivers = names,
                            .frames_given = arguments.frames.has_value(),
                            .room = geometry_of(*measurement, rays),
                            .plan = floor_plan(rays, height_m),
                            .plan_height_m = height_m}));
    file.commit();
    return 0;
}

}  // namespace aula
