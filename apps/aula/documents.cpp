#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "apps/aula/commands.h"
#include "apps/aula/outputs.h"
#include "apps/aula/room_positions.h"
#include "apps/aula/terminal/progress_bar.h"
#include "apps/dataset/plan/planned_scene.h"
#include "apps/documents/document_measurement.h"
#include "apps/documents/parameter_map.h"
#include "apps/documents/report/room_report.h"
#include "apps/output/output_file.h"
#include "apps/output/output_folder.h"
#include "aula/exception.h"
#include "engine/input/json.h"
#include "engine/mesh/mesh_import.h"
#include "engine/rays/room_survey.h"
#include "process/files.h"

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
    if (const std::error_code refused = folder_refusal(existing))
        throw InputError(folder.string(), "", "cannot be written, " + refused.message() + expected);
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
        if (new_folder_ || files_.size() >= most_open_files() / 2) commit_files();
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
    if (std::string summary = uncertainty_summary(measurement); !summary.empty())
        warnings.push_back(std::move(summary));
    warnings.insert(warnings.end(), measurement.missing_decays.begin(),
                    measurement.missing_decays.end());
    return warnings;
}

/// The sources and receivers of a report in the room, and lines on the others.
struct ReportPositions {
    std::vector<NamedPosition> inside;
    std::vector<char> in_room;  ///< [pair] of a source and a receiver: both are
    std::vector<std::string> remarks;
};

std::string text_of(const Source& source) { return "source \"" + source.name + '"'; }
std::string text_of(const NamedReceiver& receiver) { return "receiver \"" + receiver.name + '"'; }

ReportPositions report_positions(const RayScene& rays, const Scene& scene,
                                 const std::vector<NamedReceiver>& receivers) {
    std::vector<NamedPosition> all;
    for (const Source& source : scene.sources)
        all.push_back({text_of(source), source.position_at(0), {}});
    for (const NamedReceiver& receiver : receivers)
        all.push_back({text_of(receiver), receiver.position, {}});
    SortedPositions sorted = sort_positions(rays, std::move(all));
    ReportPositions result;
    std::set<std::string> outside;
    for (const NamedPosition& item : sorted.outside) {
        outside.insert(item.name);
        result.remarks.push_back(outside_text(item) + "; its pairs are not averaged");
    }
    for (const Source& source : scene.sources)
        for (const NamedReceiver& receiver : receivers)
            result.in_room.push_back(!outside.contains(text_of(source)) &&
                                     !outside.contains(text_of(receiver)));
    const auto first_receiver =
        std::find_if(sorted.inside.begin(), sorted.inside.end(),
                     [](const NamedPosition& item) { return item.name.starts_with("receiver "); });
    const std::vector<NamedPosition> sources(sorted.inside.begin(), first_receiver);
    const std::vector<NamedPosition> seats(first_receiver, sorted.inside.end());
    const auto add_cut_off = [&](const auto& places, const auto& others, const char* kind) {
        if (others.empty()) return;
        for (const NamedPosition& item : cut_off(rays, places, others))
            result.remarks.push_back(item.name + " is inside a closed body or another room" +
                                     place_text(item) + ": no sound passes from any " + kind);
    };
    add_cut_off(seats, sources, "source");
    add_cut_off(sources, seats, "receiver");
    result.inside = std::move(sorted.inside);
    return result;
}

/// The layers of the scene's mesh files, with the areas that sound reaches.
std::vector<LayerMaterial> layers_of(const Scene& scene, const RoomGeometry& room) {
    std::vector<LayerMaterial> layers;
    std::size_t first = 0;  // triangle of the object in the room
    for (const Object& object : scene.objects) {
        const std::size_t begin = std::exchange(first, first + object.triangles.size());
        if (object.files.empty()) continue;
        const ImportedMesh mesh = import_mesh(object.files[0]);
        // Unless the file has changed since the scene was read.
        if (mesh.triangles.size() != object.triangles.size()) continue;
        std::map<std::pair<std::uint32_t, std::uint32_t>, double> area_m2;  // of layer and material
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            area_m2[{mesh.triangle_materials[t], object.triangle_materials[t]}] +=
                begin + t < room.triangle_area_m2.size() ? room.triangle_area_m2[begin + t] : 0;
        for (const auto& [of, m2] : area_m2)
            layers.push_back({object.files[0].filename().string(), mesh.material_names[of.first],
                              scene.materials[of.second].name, m2});
    }
    return layers;
}

const JsonValue* member(const JsonValue& value, const std::string& key) {
    const auto* const object = std::get_if<JsonValue::Object>(&value.value);
    if (object == nullptr) return nullptr;
    for (const JsonMember& item : *object)
        if (item.key == key) return &item.value;
    return nullptr;
}

/// Where the coefficients of a scene's materials come from, by their names, as its JSON says.
std::map<std::string, std::string> material_sources_of(const JsonValue& scene) {
    std::map<std::string, std::string> sources;
    const JsonValue* const materials = member(scene, "materials");
    if (materials == nullptr) return sources;
    for (const JsonMember& material : std::get<JsonValue::Object>(materials->value)) {
        if (const JsonValue* const like = member(material.value, "like"))
            sources[material.key] =
                "given by the scene, else as \"" + std::get<std::string>(like->value) + '"';
        if (const JsonValue* const source = member(material.value, "source"))
            sources[material.key] = std::get<std::string>(source->value);
    }
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
    const RoomSection plan = floor_plan(rays, grid.height_m);
    // Before the measurement, which would be lost if the folder cannot be created.
    MapFolder folder(arguments.out);
    const auto measurement = [&] {
        ProgressBar bar("measuring at " + std::to_string(grid.receivers.size()) + " receivers",
                        arguments.quiet, ProgressLines::logged);
        return measure_map(scene, grid, arguments.frames,
                           {arguments.map_interaural, arguments.third_octaves}, std::ref(bar));
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
    std::vector<NamedReceiver> named = arguments.receivers;
    if (named.empty()) named.push_back({"listener", scene.listener.pose_at(0).position});
    std::vector<std::string> names;
    std::vector<Pose> receivers;
    for (const NamedReceiver& receiver : named) {
        names.push_back(receiver.name);
        receivers.push_back({.position = receiver.position});
    }
    // The head turns to the source; a receiver above or below it has the listener's left.
    if (arguments.receivers.empty()) receivers[0] = scene.listener.pose_at(0);
    const RayScene rays(scene);
    const ReportPositions positions =
        result_of(kMeasuring, arguments, [&] { return report_positions(rays, scene, named); });
    warn(positions.remarks, arguments.quiet);
    const RoomGeometry room = measure_room(rays, points_of(positions.inside), kRoomSeed);
    // Files may change while the report is measured.
    std::vector<LayerMaterial> layers = layers_of(scene, room);
    const auto measurement = [&] {
        ProgressBar bar("measuring", arguments.quiet, ProgressLines::logged);
        return measure_report(scene, receivers, names, arguments.frames,
                              {true, arguments.third_octaves}, std::ref(bar));
    }();
    if (!measurement) return interrupted_status();
    warn(warnings_of(*measurement), arguments.quiet);
    const auto scattering = [&] {
        ProgressBar bar("measuring with half and twice the scattering", arguments.quiet,
                        ProgressLines::logged);
        return measure_scattering(scene, receivers, arguments.frames, std::ref(bar));
    }();
    if (!scattering) return interrupted_status();
    const TaskLine line("writing the report", !arguments.quiet);
    float height_m = 0;
    for (const Pose& receiver : receivers)
        height_m += receiver.position.z / static_cast<float>(receivers.size());
    const RoomReport report{.head = arguments.head,
                            .scene_name = arguments.scene.stem().string(),
                            .program = "aula " AULA_VERSION,
                            .scene_hash = scene_hash(scene),
                            .scene = scene,
                            .measurement = *measurement,
                            .receivers = names,
                            .scattering = *scattering,
                            .in_room = positions.in_room,
                            .frames_given = arguments.frames.has_value(),
                            .room = room,
                            .plan = floor_plan(rays, height_m),
                            .plan_height_m = height_m,
                            .material_sources = material_sources_of(*loaded.json),
                            .layers = std::move(layers),
                            .guesses = loaded.guesses,
                            .remarks = positions.remarks,
                            .measured = measured};
    file.write(report_html(report));
    if (json) json->write(room_report_json(report));
    file.commit();
    if (json) json->commit();
    return 0;
}

}  // namespace aula
