// aula-bench: measures Aula and prints tables.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>

#include "apps/bench/base/settings.h"
#include "apps/bench/base/table.h"
#include "apps/bench/convolution/convolve.h"
#include "apps/bench/propagation/many_sources.h"
#include "apps/bench/propagation/noise.h"
#include "apps/bench/propagation/tessellation.h"
#include "apps/bench/propagation/trace.h"
#include "apps/bench/propagation/tracking.h"
#include "apps/session/base/output_file.h"
#include "engine/base/error.h"
#include "engine/scene/scene_file.h"

namespace {

using aula::bench::Row;
using aula::bench::Settings;
using aula::bench::Subject;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

/// Shows what is going on in one line of the terminal, if stderr is one.
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
    Subject subject(std::filesystem::path(file).filename().string(), loaded.scene, settings);
    if (settings.triangles) aula::bench::tessellate(subject.scene, *settings.triangles);
    return subject;
}

class Bench {
 public:
    Bench(const Settings& settings, ProgressLine& progress)
        : settings_(settings), progress_(progress) {}

    void noise(const std::string& file) {
        const Subject subject = load(file, settings_);
        take("noise of " + subject.description(), aula::bench::noise_columns(),
             aula::bench::measure_noise(subject, settings_));
    }

    void sweep(const std::string& file, const std::filesystem::path& plot_folder) {
        const Subject subject = load(file, settings_);
        const aula::bench::Sweep sweep = aula::bench::measure_sweep(subject, settings_);
        std::vector<Row> rows = sweep.by_tau;
        rows.insert(rows.end(), sweep.by_patch_size.begin(), sweep.by_patch_size.end());
        take("sweep of tau, then of lambda, in " + subject.description(),
             aula::bench::sweep_columns(), rows);
        if (!plot_folder.empty()) aula::bench::write_plots(sweep, plot_folder);
    }

    void tracking(const std::string& file) {
        const Subject subject = load(file, settings_);
        take("tracking in " + subject.description(), aula::bench::tracking_columns(),
             aula::bench::measure_tracking(subject, settings_));
    }

    void sources(const std::string& file) {
        const Subject subject = load(file, settings_);
        take("many sources in " + subject.description(), aula::bench::many_sources_columns(),
             aula::bench::measure_many_sources(subject, settings_));
    }

    void trace(const std::string& file) {
        const Subject subject = load(file, settings_);
        take("tracing in " + subject.description(), aula::bench::tracing_columns(),
             aula::bench::measure_tracing(subject, settings_));
    }

    void convolve(const aula::bench::ConvolutionSweep& sweep) {
        take("convolution at 48 kHz, CPU time of a block", aula::bench::convolution_columns(),
             aula::bench::measure_convolution(settings_, sweep));
        take("preparing filters", aula::bench::preparing_columns(),
             aula::bench::measure_preparing(settings_, sweep));
    }

    const std::vector<Row>& rows() const { return rows_; }

 private:
    void take(const std::string& title, const std::vector<aula::bench::Column>& columns,
              const std::vector<Row>& rows) {
        progress_.clear();
        if (rows_.empty()) std::cout << aula::bench::machine() << "\n";
        std::cout << "\n" << title << "\n" << format_table(columns, rows) << std::flush;
        rows_.insert(rows_.end(), rows.begin(), rows.end());
    }

    const Settings& settings_;
    ProgressLine& progress_;
    std::vector<Row> rows_;
};

int run(int argc, char** argv) {
    CLI::App app{
        "Measures Aula: each command prints a table of one row an estimator or a library."};
    app.require_subcommand(1);
    app.fallthrough();

    Settings settings;
    ProgressLine progress;
    settings.progress = [&](const std::string& text) { progress.show(text); };

    std::vector<std::string> estimators;
    std::string json;
    app.add_option("--estimator", estimators, "only this one: pt, dpc-published, dpc or patch")
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"pt", "dpc-published", "dpc", "patch"}));
    app.add_option("--rays", settings.rays, "per source and frame")
        ->check(CLI::Range(1, aula::Simulation::kMostRays));
    app.add_option("--order", settings.order, "highest reflection order, 0: no limit")
        ->check(CLI::Range(0, 1 << 20));
    app.add_option("--response-time", settings.response_time_s, "tau in s")
        ->check(CLI::Range(0.0, 3600.0));
    app.add_option("--patch-size", settings.patch_size_m, "lambda in m")
        ->check(CLI::Range(0.001, 1000.0));
    app.add_option("--frames", settings.frames,
                   "noise: publish after so many frames (tau times the frame rate)")
        ->check(CLI::Range(1, 1 << 20));
    app.add_option("--seed", settings.seed, "of all random numbers");
    app.add_option("--threads", settings.threads, "of the propagation")->check(CLI::Range(1, 1024));
    app.add_option("--restarts", settings.restarts, "noise: independent restarts")
        ->capture_default_str()
        ->check(CLI::Range(2, 1 << 20));
    app.add_option("--positions", settings.positions, "tracking: places of the walk")
        ->capture_default_str()
        ->check(CLI::Range(1, 1 << 10));
    app.add_option("--rest", settings.rest_s, "tracking: all stand so many s before the walk")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 3600.0));
    app.add_option("--sources", settings.sources, "sources: so many beside one")
        ->capture_default_str()
        ->check(CLI::Range(2, 1024));
    app.add_option("--reference-rays", settings.reference_rays,
                   "at most, though the reference has not converged")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 1e12));
    app.add_option("--triangles", settings.triangles,
                   "divide the surfaces into so many triangles or more")
        ->check(CLI::Range(1, 1 << 24));
    app.add_option("--json", json, "write the rows to this file, too");

    std::string scene;
    std::vector<std::string> scenes;
    CLI::App* noise = app.add_subcommand(
        "noise", "how much a response differs from one restart to the next, beside its bias");
    noise->add_option("SCENE", scene, "scene file")->required();
    CLI::App* tracking =
        app.add_subcommand("tracking", "the error while the listener or the source walks");
    tracking->add_option("SCENE", scene, "scene file")->required();
    CLI::App* crowd = app.add_subcommand("sources", "what many sources cost beside one");
    crowd->add_option("SCENE", scene, "scene file")->required();
    std::string plot_folder;
    CLI::App* sweep =
        app.add_subcommand("sweep", "noise, bias and cost over ranges of tau and of lambda");
    sweep->add_option("SCENE", scene, "scene file")->required();
    sweep->add_option("--plot", plot_folder, "draw them as SVG files into this folder")
        ->check(CLI::ExistingDirectory);
    CLI::App* trace =
        app.add_subcommand("trace", "segments a second of whole frames beside Embree alone");
    trace->add_option("SCENE", scene, "scene file")->required();
    trace->add_option("--ir-length", settings.response_length_s, "of responses in s (the room's)")
        ->check(CLI::Range(0.01, 10.0));
    CLI::App* convolve = app.add_subcommand(
        "convolve", "what a block costs the audio thread, beside other libraries");
    aula::bench::ConvolutionSweep convolution_sweep;
    convolve->add_option("--ir-length", convolution_sweep.responses_s, "s, one or more (1 2 4)")
        ->check(CLI::Range(0.01, 10.0));
    convolve->add_option("--block", convolution_sweep.blocks, "one or more (64 128 256 512)")
        ->check(CLI::Range(64, 4096));
    convolve
        ->add_option("--rounds", convolution_sweep.rounds,
                     "of which the best one's mean counts, and a block's median")
        ->capture_default_str()
        ->check(CLI::Range(1, 1000));
    CLI::App* all = app.add_subcommand("all", "noise, tracking, trace and convolve");
    all->add_option("SCENE", scenes, "scene files")->required();

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

    try {
        // Opened first: what is measured for hours shall not be lost for a wrong name.
        std::optional<aula::OutputFile> output;
        if (!json.empty()) output.emplace(json);
        Bench bench(settings, progress);
        if (*noise) bench.noise(scene);
        if (*sweep) bench.sweep(scene, plot_folder);
        if (*tracking) bench.tracking(scene);
        if (*crowd) bench.sources(scene);
        if (*trace) bench.trace(scene);
        if (*convolve) bench.convolve(convolution_sweep);
        if (*all) {
            for (const std::string& file : scenes) {
                bench.noise(file);
                bench.tracking(file);
                bench.trace(file);
            }
            bench.convolve(convolution_sweep);
        }
        if (output) {
            output->write(aula::bench::to_json(bench.rows()));
            output->commit();
        }
    } catch (const aula::Error& e) {
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
