#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/aula/arguments/dataset_arguments.h"
#include "apps/documents/document_measurement.h"
#include "apps/documents/report/room_report.h"
#include "apps/room/base/playback_options.h"
#include "apps/room/remote/osc_options.h"
#include "aula/engine/scene.h"
#include "aula/measurement.h"
#include "engine/model/model_scene.h"

namespace aula {

/// A receiver of Command::report.
struct NamedReceiver {
    std::string name;
    Vec3 position{0};
};

/// The parsed command line.
struct Arguments {
    enum class Command {
        help,
        version,
        list_devices,
        materials,
        info,
        check,
        import,
        play,
        render,
        measure,
        map,
        report,
        analyse,
        dataset
    };

    Command command = Command::play;
    std::string help;  ///< Command::help: the command that it is asked of; empty: the program
    std::filesystem::path scene;
    std::optional<std::string> material;       ///< `materials show`: its name
    std::optional<std::string> material_word;  ///< `materials WORD`: a search
    std::filesystem::path offline;             ///< output of Command::render
    std::optional<std::filesystem::path> ir;   ///< outputs of Command::measure
    std::optional<std::filesystem::path> echogram;
    std::optional<std::filesystem::path> report_json;
    bool report = false;
    std::optional<int> frames;
    double bin_s = 1e-3;
    /// Folder of Command::map; file of Command::import, empty: standard output; file of
    /// Command::analyse, empty: none.
    std::filesystem::path out;
    ModelOptions model;  ///< of Command::import
    double map_height_m = kMapHeight_m;
    std::string map_surface;  ///< a material or an object; empty: a plane at the height
    double map_offset_m = kMapHeight_m;
    double map_spacing_m = kMapSpacing_m;
    bool map_interaural = false;                   ///< true: maps of IACC, too
    std::filesystem::path html;                    ///< output of Command::report
    std::vector<NamedReceiver> receivers;          ///< of Command::report; empty: the listener
    std::optional<std::filesystem::path> json;     ///< output of Command::report, too
    ReportHead head;                               ///< of Command::report
    std::vector<std::filesystem::path> measured;   ///< of Command::report: values to compare with
    std::vector<std::filesystem::path> responses;  ///< files of Command::analyse
    bool third_octaves = false;                    ///< of parameters
    /// Of --speech-level and --noise-level; a scene takes them by `scene_changes`.
    std::optional<Bands> speech_db{};
    std::optional<Bands> noise_db{};
    PlaybackOptions playback;
    bool rays_given = false;
    bool quiet = false;
    bool strict = false;  ///< of Command::check: each warning changes the exit status
    bool window = true;   ///< open one where possible
    std::optional<std::filesystem::path> scene_dir;  ///< of scenes for page up and down
    std::optional<std::filesystem::path> screenshot;
    double screenshot_after_s = 5;
    std::optional<OscOptions> osc;  ///< OSC messages to receive
    DatasetArguments dataset;       ///< of Command::dataset

    /// Changes of the scene by options, in command-line order. Each throws InputError.
    std::vector<std::function<void(Scene&)>> scene_changes;
};

/// Parses the command line. Throws InputError: one line that begins with the option.
Arguments read_arguments(int argc, const char* const* argv);

/// The text of --help; of `aula COMMAND --help` the parts that concern the command.
std::string help_text(const std::string& command);

}  // namespace aula
