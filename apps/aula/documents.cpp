#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/aula/commands.h"
#include "apps/aula/outputs.h"
#include "apps/aula/terminal/progress_bar.h"
#include "apps/dataset/plan/planned_scene.h"
#include "apps/documents/document_measurement.h"
#include "apps/documents/parameter_map.h"
#include "apps/documents/room_report.h"
#include "apps/session/base/output_file.h"
#include "apps/session/base/output_folder.h"
#include "aula/exception.h"
#include "engine/input/json.h"

namespace aula {

namespace {

namespace fs = std::filesystem;

/// Throws InputError if files cannot be written to a folder, which need not exist yet.
void check_folder(const fs::path& folder) {
    std::error_code error;
    fs::path existing = folder;
    // A link to nothing is no place for a folder.
    while (!existing.empty() && !fs::exists(fs::symlink_status(existing, error)))
        existing = existing.parent_path();
    if (existing.empty()) existing = ".";
    const char* const expected = "; expected the name of a folder to write to";
    if (!fs::is_directory(existing, error))
        throw InputError(folder.string(), "",
                         existing.string() + " is not a folder" + std::string(expected));
    if (access(existing.c_str(), W_OK | X_OK) != 0)
        throw InputError(folder.string(), "",
                         "cannot be written, " + std::generic_category().message(errno) + expected);
}

/// The files of a map. A new folder appears whole. In an existing one, which may contain other
/// files, each file is replaced for itself, after all have been written.
class MapFolder {
 public:
    explicit MapFolder(const fs::path& folder) {
        std::error_code error;
        if (fs::exists(folder, error)) return;
        new_folder_.emplace(folder);
        // A killed process had renamed it aside, or another program has created it by now.
        if (new_folder_->replaces()) new_folder_.reset();
    }

    void write(const fs::path& file, const std::string& content) {
        // Half of the open files that the system allows, usually 1024: enough for the maps of 27
        // sources.
        rlimit files{.rlim_cur = 256, .rlim_max = 256};
        getrlimit(RLIMIT_NOFILE, &files);
        if (new_folder_ || files_.size() >= files.rlim_cur / 2) commit_files();
        files_.push_back(new_folder_ ? std::make_unique<OutputFile>(
                                           new_folder_->path(file.filename().string()), file)
                                     : std::make_unique<OutputFile>(file));
        files_.back()->write(content);
    }

    void commit() {
        commit_files();
        if (new_folder_) new_folder_->commit();
    }

 private:
    void commit_files() {
        for (const auto& file : files_) file->commit();
        files_.clear();
    }

    std::optional<OutputFolder> new_folder_;
    std::vector<std::unique_ptr<OutputFile>> files_;
};

/// Writes a picture and a table of each parameter of each source. Returns false after a signal.
bool write_maps(const Arguments& arguments, const ParameterMap& map, const Scene& scene,
                MapFolder& folder) {
    ProgressBar bar("drawing the maps", arguments.quiet);
    const auto parameters = mapped_parameters(arguments.map_interaural);
    const double count =
        static_cast<double>(scene.sources.size()) * static_cast<double>(parameters.size());
    double done = 0;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        for (const std::size_t parameter : parameters) {
            if (!bar(done++ / count)) return false;
            const auto [table, picture] = map_files(arguments, scene, s, parameter);
            folder.write(table, map_csv(map, s, parameter));
            folder.write(picture, map_png(map, s, parameter, arguments.scene.stem().string()));
        }
    }
    folder.commit();
    return true;
}

/// Warnings of a map: how many receivers are not audible or have larger errors than wanted.
std::vector<std::string> map_warnings(const Measurement& measurement) {
    std::vector<std::string> warnings = measurement.warnings;
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
    const auto uncertain =
        std::count_if(measurement.uncertain.begin(), measurement.uncertain.end(),
                      [](const std::string& parameters) { return !parameters.empty(); });
    if (uncertain > 0)
        warnings.push_back("standard errors after " + std::to_string(measurement.frames) +
                           " frames are larger than wanted at " + std::to_string(uncertain) +
                           " of " + std::to_string(measurement.audible.size()) +
                           " pairs of source and receiver");
    warnings.insert(warnings.end(), measurement.missing_decays.begin(),
                    measurement.missing_decays.end());
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

const JsonValue* member(const JsonValue& value, const std::string& key) {
    const auto* const object = std::get_if<JsonValue::Object>(&value.value);
    if (object == nullptr) return nullptr;
    for (const JsonMember& item : *object)
        if (item.key == key) return &item.value;
    return nullptr;
}

/// The layers of the mesh files of a scene's JSON, which has been read without errors.
std::vector<LayerMaterial> layers_of(const JsonValue& scene) {
    std::vector<LayerMaterial> layers;
    const JsonValue* const geometry = member(scene, "geometry");
    if (geometry == nullptr) return layers;
    for (const JsonValue& object : std::get<JsonValue::Array>(geometry->value)) {
        const JsonValue* const file = member(object, "file");
        const JsonValue* const materials = member(object, "materials");
        if (file == nullptr || materials == nullptr) continue;
        const std::string name = fs::path(std::get<std::string>(file->value)).filename().string();
        for (const JsonMember& layer : std::get<JsonValue::Object>(materials->value))
            layers.push_back({name, layer.key, std::get<std::string>(layer.value.value)});
    }
    return layers;
}

/// Where the coefficients of a scene's materials come from, by their names, as its JSON says.
std::map<std::string, std::string> material_sources_of(const JsonValue& scene) {
    std::map<std::string, std::string> sources;
    const JsonValue* const materials = member(scene, "materials");
    if (materials == nullptr) return sources;
    for (const JsonMember& material : std::get<JsonValue::Object>(materials->value))
        if (const JsonValue* const source = member(material.value, "source"))
            sources[material.key] = std::get<std::string>(source->value);
    return sources;
}

/// The measured values that a report compares with; prints warnings.
std::vector<MeasuredResponse> measured_responses(const Arguments& arguments) {
    std::vector<MeasuredResponse> all;
    for (const fs::path& file : arguments.measured) {
        std::vector<std::string> warnings;
        for (MeasuredResponse& response : read_measured(file, warnings))
            all.push_back(std::move(response));
        warn(warnings, arguments.quiet);
    }
    return all;
}

}  // namespace

int map_room(const Arguments& arguments) {
    const Scene scene = read_scene(arguments);
    check_folder(arguments.out);
    const RayScene rays(scene);
    const ReceiverGrid grid = [&] {
        const TaskLine line("finding receivers in the room", !arguments.quiet);
        if (!arguments.map_surface.empty())
            return surface_grid(scene, rays, arguments.map_surface, arguments.map_offset_m,
                                arguments.map_spacing_m);
        return receiver_grid(scene, rays, arguments.map_height_m, arguments.map_spacing_m);
    }();
    const FloorPlan plan = floor_plan(rays, grid.height_m);
    // Before the measurement, which would be lost if the folder cannot be created.
    MapFolder folder(arguments.out);
    const auto measurement = [&] {
        ProgressBar bar("measuring at " + std::to_string(grid.receivers.size()) + " receivers",
                        arguments.quiet, ProgressLines::logged);
        return measure_map(scene, grid, arguments.frames, arguments.map_interaural, std::ref(bar));
    }();
    if (!measurement) return interrupted_status();
    warn(map_warnings(*measurement), arguments.quiet);
    return write_maps(arguments, {grid, plan, *measurement}, scene, folder) ? 0
                                                                            : interrupted_status();
}

int report_room(const Arguments& arguments) {
    LoadedScene loaded = read_scene_file(arguments.scene, arguments);
    change_scene(loaded.scene, arguments);
    const Scene& scene = loaded.scene;
    check_outputs(arguments, scene);
    const std::vector<MeasuredResponse> measured = measured_responses(arguments);
    OutputFile file(arguments.html);
    std::optional<OutputFile> json;
    if (arguments.json) json.emplace(*arguments.json);
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
        ProgressBar bar("measuring", arguments.quiet, ProgressLines::logged);
        return measure_report(scene, receivers, names, arguments.frames, std::ref(bar));
    }();
    if (!measurement) return interrupted_status();
    warn(warnings_of(*measurement), arguments.quiet);
    const TaskLine line("writing the report", !arguments.quiet);
    const RayScene rays(scene);
    float height_m = 0;
    for (const Pose& receiver : receivers)
        height_m += receiver.position.z / static_cast<float>(receivers.size());
    const RoomReport report{.head = arguments.head,
                            .title = arguments.scene.stem().string(),
                            .program = "aula " AULA_VERSION,
                            .scene_hash = scene_hash(scene),
                            .scene = scene,
                            .measurement = *measurement,
                            .receivers = names,
                            .frames_given = arguments.frames.has_value(),
                            .room = geometry_of(*measurement, rays),
                            .plan = floor_plan(rays, height_m),
                            .plan_height_m = height_m,
                            .material_sources = material_sources_of(*loaded.json),
                            .layers = layers_of(*loaded.json),
                            .guesses = loaded.guesses,
                            .measured = measured};
    file.write(report_html(report));
    if (json) json->write(room_report_json(report));
    file.commit();
    if (json) json->commit();
    return 0;
}

}  // namespace aula
