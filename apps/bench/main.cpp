// aula-bench: measures Aula and prints tables.
#include <pthread.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <thread>

#include "apps/bench/base/machine.h"
#include "apps/bench/base/measurement_file.h"
#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"
#include "apps/bench/convolution/convolve.h"
#include "apps/bench/propagation/changes.h"
#include "apps/bench/propagation/diffraction.h"
#include "apps/bench/propagation/fluctuation.h"
#include "apps/bench/propagation/many_sources.h"
#include "apps/bench/propagation/noise.h"
#include "apps/bench/propagation/receivers.h"
#include "apps/bench/propagation/rest.h"
#include "apps/bench/propagation/tessellation.h"
#include "apps/bench/propagation/trace.h"
#include "apps/bench/propagation/tracking.h"
#include "apps/bench/rendering/budget.h"
#include "apps/bench/rendering/heard.h"
#include "apps/bench/waves/waves.h"
#include "apps/output/output_file.h"
#include "audio/file/part_file.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"

namespace {

using aula::bench::Row;
using aula::bench::Settings;
using aula::bench::Subject;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

/// Shows the present step in one line of stderr if that is a terminal.
class ProgressLine {
 public:
    void show(const std::string& text) {
        if (!terminal_) return;
        std::cerr << "\r\033[K" << text << std::flush;
    }
    void clear() {
        if (terminal_) std::cerr << "\r\033[K" << std::flush;
    }

 private:
    bool terminal_ = isatty(STDERR_FILENO) != 0;
};

Subject load(const std::string& file, const Settings& settings) {
    const aula::LoadedScene loaded = aula::load_scene(file);
    for (const std::string& warning : loaded.warnings) {
        std::cerr << "aula: warning: " << warning << "\n";
    }
    aula::Scene scene = loaded.scene;
    // The path tracer that gives the references has omnidirectional sources.
    for (aula::Source& source : scene.sources) source.directivity = {};
    Subject subject(std::filesystem::path(file).filename().string(), scene, settings);
    if (settings.triangles) aula::bench::tessellate(subject.scene, *settings.triangles);
    return subject;
}

/// Measures, prints each table when it is complete, and stores all of them.
class Bench {
 public:
    Bench(const Settings& settings, const std::string& command, ProgressLine& progress)
        : settings_(settings), progress_(progress), document_(command) {}

    void noise(const Subject& subject) {
        take("noise of " + subject.description(), aula::bench::noise_columns(),
             aula::bench::measure_noise(subject, settings_));
    }

    void sweep(const Subject& subject) {
        take("sweep of tau, then of lambda, in " + subject.description(),
             aula::bench::sweep_columns(), aula::bench::measure_sweep(subject, settings_));
    }

    void tracking(const Subject& subject) {
        take("tracking in " + subject.description(), aula::bench::tracking_columns(),
             aula::bench::measure_tracking(subject, settings_));
    }

    void rest(const Subject& subject) {
        take("10 s at rest in " + subject.description(), aula::bench::rest_columns(),
             aula::bench::measure_rest(subject, settings_));
    }

    void fluctuation(const Subject& subject) {
        take("fluctuation during a walk in " + subject.description(),
             aula::bench::fluctuation_columns(),
             aula::bench::measure_fluctuation(subject, settings_));
    }

    void sources(const Subject& subject) {
        take("many sources in " + subject.description(), aula::bench::many_sources_columns(),
             aula::bench::measure_many_sources(subject, settings_));
    }

    void receivers(const Subject& subject) {
        take("receivers of a measurement in " + subject.description(),
             aula::bench::receivers_columns(), aula::bench::measure_receivers(subject, settings_));
    }

    void budget(const Subject& subject) {
        take("offline rendering of " + subject.description(), aula::bench::budget_columns(),
             aula::bench::measure_budget(subject, settings_));
    }

    void heard(const Subject& subject) {
        take("heard in " + subject.description(), aula::bench::heard_columns(),
             aula::bench::measure_heard(subject, settings_));
    }

    void changes(const Subject& subject) {
        take("changes in " + subject.description(), aula::bench::changes_columns(),
             aula::bench::measure_changes(subject, settings_));
    }

    void diffraction(const Subject& subject) {
        take("diffraction in " + subject.description(), aula::bench::diffraction_columns(),
             aula::bench::measure_diffraction(subject, settings_));
    }

    void edge_search(const Subject& subject) {
        take("loading of copies of " + subject.name, aula::bench::edge_search_columns(),
             aula::bench::measure_edge_search(subject, settings_));
    }

    /// The level in a mesh file; none, with a line that says so, if there is no such file.
    std::optional<Subject> level(const std::string& mesh_file) {
        if (mesh_file.empty()) return {};
        if (!std::filesystem::exists(mesh_file)) {
            progress_.clear();
            std::cout << "\ndiffraction in a level: skipped, no " << mesh_file << "\n";
            return {};
        }
        return aula::bench::level_of(mesh_file, settings_);
    }

    void trace(const Subject& subject) {
        take("tracing in " + subject.description(), aula::bench::tracing_columns(),
             aula::bench::measure_tracing(subject, settings_));
    }

    void convolve(const aula::bench::ConvolutionSweep& sweep) {
        take("convolution at 48 kHz, CPU time of a block", aula::bench::convolution_columns(),
             aula::bench::measure_convolution(settings_, sweep));
        take("preparing filters", aula::bench::preparing_columns(),
             aula::bench::measure_preparing(settings_, sweep));
    }

    void waves(const Subject& subject) {
        take("waves in " + subject.name, aula::bench::waves_columns(),
             aula::bench::measure_waves(subject, settings_));
    }

    const std::vector<Row>& rows() const { return rows_; }
    const std::string& document() const { return document_.text(); }

 private:
    void take(const std::string& title, const std::vector<aula::bench::Column>& columns,
              const std::vector<Row>& rows) {
        progress_.clear();
        if (rows_.empty()) std::cout << aula::bench::machine_line() << "\n";
        std::cout << "\n" << title << "\n" << format_table(columns, rows) << std::flush;
        document_.add(title, columns, rows);
        rows_.insert(rows_.end(), rows.begin(), rows.end());
    }

    const Settings& settings_;
    ProgressLine& progress_;
    aula::bench::MeasurementFile document_;
    std::vector<Row> rows_;
};

/// A command that prints a table for each scene.
struct SceneCommand {
    const char* name;
    const char* description;
    void (Bench::*measure)(const Subject& subject);
};

constexpr std::array kSceneCommands{
    SceneCommand{"noise", "deviation of a response between restarts, and its bias", &Bench::noise},
    SceneCommand{"tracking", "the error while the listener or the source moves", &Bench::tracking},
    SceneCommand{"rest", "the error after 10 s at rest, with the rays that a frame's time allows",
                 &Bench::rest},
    SceneCommand{"fluctuation", "levels of pink noise during a walk, against a walk with many rays",
                 &Bench::fluctuation},
    SceneCommand{"sources", "the cost of many sources and of one", &Bench::sources},
    SceneCommand{"receivers",
                 "the cost of an additional receiver of a measurement relative to that of a source",
                 &Bench::receivers},
    SceneCommand{"changes",
                 "the mean and the worst frame while source or listener walk or jump, or objects "
                 "move",
                 &Bench::changes},
    SceneCommand{"budget",
                 "the rays and the CPU time of offline rendering: qualities, numbers of sources",
                 &Bench::budget},
    SceneCommand{
        "heard",
        "echo density, statistics and decay of the reverberation, and its change over places",
        &Bench::heard},
    SceneCommand{"sweep", "noise, bias and cost over ranges of tau and of lambda", &Bench::sweep},
    SceneCommand{
        "waves",
        "the modes of a room: their number and cost, and their level over rays and a finer grid",
        &Bench::waves},
    SceneCommand{"trace", "segments per second of whole frames, and of Embree alone",
                 &Bench::trace},
};

/// The command line without the program's folder.
std::string command_line(int argc, char** argv) {
    std::string command = std::filesystem::path(argv[0]).filename();
    for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
    return command;
}

/// Removes unfinished files at SIGINT, SIGTERM or SIGHUP and exits. To be called before other
/// threads start: they inherit the blocked signals.
void remove_files_at_signals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([signals] {
        int signal = 0;
        while (sigwait(&signals, &signal) != 0) {
        }
        aula::PartFile::abandon_all();
        _exit(128 + signal);
    }).detach();
}

int run(int argc, char** argv) {
    CLI::App app{"Measures Aula: each command prints a table, one row per estimator or library."};
    app.require_subcommand(1);
    app.fallthrough();

    Settings settings;
    ProgressLine progress;
    settings.progress = [&](const std::string& text) { progress.show(text); };

    aula::bench::ConvolutionSweep convolution_sweep;
    // First, because options take effect in this order: given sizes override these.
    app.add_flag_callback(
        "--quick",
        [&] {
            settings.restarts = 16;
            settings.positions = 3;
            settings.longest_walk_s = 2;
            settings.walks = 2;
            settings.reference_rays = 1e6;
            convolution_sweep = {{2}, {64, 128, 512}, 5};
        },
        "smaller default sizes: a few minutes per scene");
    std::vector<std::string> estimators;
    std::string json;
    std::string level;
    std::string markdown;
    app.add_option("--estimator", estimators, "only this one: pt, dpc-published, dpc or patch")
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"pt", "dpc-published", "dpc", "patch"}));
    app.add_option("--rays", settings.rays, "per source and frame")
        ->check(CLI::Range(1, aula::Simulation::kMaxRays));
    app.add_option("--order", settings.order, "highest reflection order, 0: no limit")
        ->check(CLI::Range(0, 1 << 20));
    app.add_option("--response-time", settings.response_time_s, "tau in s")
        ->check(CLI::Range(0.0, 3600.0));
    app.add_option("--patch-size", settings.patch_size_m, "lambda in m")
        ->check(CLI::Range(0.001, 1000.0));
    app.add_option("--frames", settings.frames,
                   "noise: before a response is read (tau times the frame rate)")
        ->check(CLI::Range(1, 1 << 20));
    app.add_option("--seed", settings.seed, "of all random numbers");
    app.add_option("--threads", settings.threads, "of the propagation")->check(CLI::Range(1, 1024));
    app.add_option("--restarts", settings.restarts, "noise: independent restarts")
        ->capture_default_str()
        ->check(CLI::Range(2, 1 << 20));
    app.add_option("--positions", settings.positions, "tracking: measured on the walk")
        ->capture_default_str()
        ->check(CLI::Range(1, 1 << 10));
    app.add_option("--walks", settings.walks, "tracking: repetitions with seeds of their own")
        ->capture_default_str()
        ->check(CLI::Range(1, 1 << 10));
    app.add_option("--rest", settings.rest_s, "tracking: s at rest before the walk")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 3600.0));
    app.add_option("--frame-ms", settings.frame_ms, "rest: CPU time of a frame in ms")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 1e4));
    app.add_option("--sources", settings.sources, "sources: number that is compared with one")
        ->capture_default_str()
        ->check(CLI::Range(2, 1024));
    app.add_option("--reference-rays", settings.reference_rays,
                   "at most; a reference may end before it has converged")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 1e12));
    app.add_option("--reference-s", settings.reference_s, "at most: CPU time of a reference in s")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--triangles", settings.triangles, "divide the surfaces into at least as many")
        ->check(CLI::Range(1, 1 << 24));
    app.add_option("--json", json, "also write the rows to this file");
    app.add_option("--markdown", markdown, "also write the tables to this file");

    std::vector<std::string> scenes;
    std::vector<CLI::App*> of_scenes;
    for (const SceneCommand& command : kSceneCommands) {
        of_scenes.push_back(app.add_subcommand(command.name, command.description));
    }
    app.get_subcommand("trace")
        ->add_option("--ir-length", settings.response_length_s, "of responses in s (the room's)")
        ->check(CLI::Range(0.01, 10.0));
    CLI::App* convolve =
        app.add_subcommand("convolve", "CPU time of a block, also in other libraries");
    CLI::App* diffraction = app.add_subcommand(
        "diffraction", "the share of diffraction in the time of frames, and its time at loading");
    CLI::App* all = app.add_subcommand("all",
                                       "noise, rest, trace, receivers, changes and diffraction of "
                                       "each scene, tracking, fluctuation and sources of those "
                                       "with a path, and convolve");
    of_scenes.insert(of_scenes.end(), {diffraction, all});
    for (CLI::App* command : of_scenes) {
        command->add_option("SCENE", scenes, "scene files")->required();
    }
    for (CLI::App* command : {diffraction, all}) {
        command->add_option("--level", level,
                            "diffraction: also in the level of a game, a mesh file with y up");
    }
    for (CLI::App* command : {convolve, all}) {
        const bool many = command == convolve;  // else the next word may be a scene
        command->add_option("--ir-length", convolution_sweep.responses_s, "of filters, s (1 2 4)")
            ->allow_extra_args(many)
            ->check(CLI::Range(0.01, 10.0));
        command->add_option("--block", convolution_sweep.blocks, "samples (64 128 256 512)")
            ->allow_extra_args(many)
            ->check(CLI::Range(64, 4096));
        command
            ->add_option("--rounds", convolution_sweep.rounds,
                         "the best round's mean counts, and a block's median")
            ->capture_default_str()
            ->check(CLI::Range(1, 1000));
    }

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& e) {
        return app.exit(e);
    } catch (const CLI::ParseError& e) {
        std::cerr << "aula-bench: " << e.what() << "\n";
        return kBadInput;
    }
    if (!estimators.empty()) {
        settings.estimators.clear();
        for (const std::string& name : estimators) {
            settings.estimators.push_back(*aula::estimator_from_name(name));
        }
    }

    remove_files_at_signals();
    try {
        // Opened first, so that a wrong name does not cost hours of measurements.
        std::optional<aula::OutputFile> json_file;
        std::optional<aula::OutputFile> markdown_file;
        if (!json.empty()) json_file.emplace(json);
        if (!json.empty() && std::filesystem::weakly_canonical(json) ==
                                 std::filesystem::weakly_canonical(markdown)) {
            throw aula::InputError(markdown, "--markdown",
                                   "is also the file of --json; expected another");
        }
        if (!markdown.empty()) markdown_file.emplace(markdown);
        // The end of the reader of standard output must not end the program before its files are
        // written.
        if (json_file || markdown_file) std::signal(SIGPIPE, SIG_IGN);
        Bench bench(settings, command_line(argc, argv), progress);
        std::vector<Subject> subjects;
        for (const std::string& file : scenes) subjects.push_back(load(file, settings));
        for (const SceneCommand& command : kSceneCommands) {
            if (!*app.get_subcommand(command.name)) continue;
            for (const Subject& subject : subjects) (bench.*command.measure)(subject);
        }
        if (*diffraction) {
            if (std::optional<Subject> found = bench.level(level)) subjects.push_back(*found);
            for (const Subject& subject : subjects) {
                bench.diffraction(subject);
                bench.edge_search(subject);
            }
        }
        if (*convolve) bench.convolve(convolution_sweep);
        if (*all) {
            for (const Subject& subject : subjects) {
                const bool listener_moves = subject.scene.listener.path.has_value();
                bench.noise(subject);
                bench.rest(subject);
                if (listener_moves || subject.scene.sources[0].path) {
                    bench.tracking(subject);
                    bench.fluctuation(subject);
                }
                bench.trace(subject);
                if (listener_moves) bench.sources(subject);
                bench.receivers(subject);
                bench.changes(subject);
                bench.diffraction(subject);
            }
            if (const std::optional<Subject> found = bench.level(level)) bench.diffraction(*found);
            bench.convolve(convolution_sweep);
        }
        if (json_file) {
            json_file->write(aula::bench::to_json(bench.rows()));
            json_file->commit();
        }
        if (markdown_file) {
            markdown_file->write(bench.document());
            markdown_file->commit();
        }
    } catch (const aula::InputError& e) {
        progress.clear();
        std::cerr << "aula-bench: " << e.what() << "\n";
        return kBadInput;
    } catch (const std::exception& e) {
        progress.clear();
        std::cerr << "aula-bench: " << e.what() << "\n";
        return kFailed;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) { return run(argc, argv); }
