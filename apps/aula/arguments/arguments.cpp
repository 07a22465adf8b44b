#include "apps/aula/arguments/arguments.h"

#include <CLI/CLI.hpp>
#include <limits>

#include "apps/aula/arguments/argument_values.h"
#include "apps/aula/arguments/position_changes.h"
#include "apps/room/remote/osc.h"
#include "audio/spatial/ambisonics.h"
#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

/// A message in Aula's form. CLI11's messages begin or end with the option's name.
std::string parse_message(const CLI::ParseError& error) {
    const std::string text = error.what();
    const std::string name = text.substr(0, text.find(':'));
    const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
        return "\"" + text.substr(text.rfind(' ') + 1) +
               "\" is not known; expected what aula --help lists";
    if (has("missing")) return name + ": has no value; expected one";
    if (has("but received")) return name + ": is given more than once; expected it once";
    if (has("Could not convert")) {
        const std::size_t begin = text.find("--");
        return text.substr(begin, text.find(' ', begin) - begin) + ": takes no value";
    }
    return text + "; expected what aula --help lists";
}

/// The options of the program. CLI11 finds them on the command line. Their values are parsed here,
/// so that each message contains what was expected.
class Options {
 public:
    explicit Options(Arguments& arguments) : arguments_(arguments) {
        app_.set_help_flag();
        app_.allow_windows_style_options(false);
        app_.add_option("SCENE", words_, "scene, or a command and its scene");
        add_modes();
        add_documents();
        add_positions();
        add_simulation();
        add_sound();
        add_window();
        app_.add_flag("--quiet", arguments_.quiet);
        app_.add_flag("--strict", arguments_.strict);
        app_.add_flag("--version", version_);
        app_.add_flag("--help,-h", help_);
    }

    void parse(int argc, const char* const* argv) {
        for (int i = 1; i < argc; ++i)
            for (const char* const none : {"", "-"})
                if (argv[i] == std::string("--report=") + none)
                    refuse_value("--report", none, "the name of a file");
        try {
            app_.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            throw InputError(parse_message(error));
        }
        for (const std::string& file : measured_) arguments_.measured.push_back(utf8_path(file));
        arguments_.command = command();
    }

 private:
    void text(const std::string& option, const std::function<void(const std::string&)>& take) {
        app_.add_option_function<std::string>(option, take);
    }

    void path(const std::string& option, std::optional<std::filesystem::path>& out) {
        text(option, [option, &out](const std::string& value) {
            if (value.empty()) refuse_value(option, value, "the name of a file");
            if (value == "-") refuse_value(option, value, "the name of a file; /dev/stdout or ./-");
            out = utf8_path(value);
        });
    }

    template <typename T>
    void choice(const std::string& option, std::vector<std::pair<std::string, T>> choices,
                std::function<void(T)> take) {
        text(option, [=](const std::string& value) {
            std::string names;
            for (const auto& [name, chosen] : choices) {
                if (name == value) return take(chosen);
                names += (names.empty() ? "" : ", ") + name;
            }
            refuse_value(option, value, "one of " + names);
        });
    }

    template <typename T>
    void integer(const std::string& option, T min, T max, std::function<void(T)> take) {
        text(option, [=](const std::string& value) { take(read_whole(option, value, min, max)); });
    }

    /// A number above 0, or at least 0 if `zero` is allowed.
    void real(const std::string& option, double max, const std::string& expected,
              std::function<void(double)> take, bool zero = false) {
        const double min = zero ? 0 : std::numeric_limits<float>::min();
        text(option, [=](const std::string& value) {
            take(read_number(option, value, min, max, expected));
        });
    }

    /// A callback that changes a member of the scene's simulation.
    auto simulation(auto Simulation::*member) {
        return [this, member](auto value) {
            arguments_.scene_changes.push_back([member, value](Scene& scene) {
                using Member = std::remove_reference_t<decltype(scene.simulation.*member)>;
                scene.simulation.*member = static_cast<Member>(value);
            });
        };
    }

    void add_modes() {
        path("--offline", offline_);
        path("--ir", arguments_.ir);
        path("--echogram", arguments_.echogram);
        // A flag: `--report SCENE` must not consume SCENE. An empty string means no file.
        app_.add_flag("--report{}", report_);
        integer<int>("--frames", 1, 1'000'000, [this](int n) { arguments_.frames = n; });
        constexpr double kNarrowestBin_ms = 0.01;
        const char* const widths = "milliseconds from 0.01 to 1000";
        real("--bin-ms", 1000, widths, [this, widths](double ms) {
            if (ms < kNarrowestBin_ms) refuse_value("--bin-ms", std::to_string(ms), widths);
            arguments_.bin_s = ms / 1000;
        });
        text("--speech-level", [this](const std::string& value) {
            const Bands levels_db = read_levels("--speech-level", value,
                                                "a level in dB(A) at 1 m, or 8 octave levels in dB",
                                                SpeechConditions::male_speech_db);
            arguments_.speech_db = levels_db;
            arguments_.scene_changes.push_back(
                [levels_db](Scene& scene) { scene.speech.speech_db = levels_db; });
        });
        text("--noise-level", [this](const std::string& value) {
            const Bands levels_db =
                read_levels("--noise-level", value, "a level in dB for each octave, or 8 of them",
                            Bands::filled);
            arguments_.noise_db = levels_db;
            arguments_.scene_changes.push_back(
                [levels_db](Scene& scene) { scene.speech.noise_db = levels_db; });
        });
        app_.add_flag("--list-devices", list_devices_);
    }

    /// Options of the commands `map`, `report` and `import`, which other commands do not have.
    void add_documents() {
        path("--html", html_);
        path("--json", arguments_.json);
        for (const auto& [name, text] : {std::pair("--project", &arguments_.head.project),
                                         std::pair("--client", &arguments_.head.client),
                                         std::pair("--author", &arguments_.head.author),
                                         std::pair("--date", &arguments_.head.date)})
            app_.add_option(name, *text);
        app_.add_option("--receiver", receivers_)->allow_extra_args(false);
        app_.add_option("--measured", measured_)->allow_extra_args(false);
        path("--out", out_);
        constexpr double kHighest_m = 1e6;
        text("--height", [this](const std::string& value) {
            arguments_.map_height_m =
                read_number("--height", value, -kHighest_m, kHighest_m, "metres from -1e6 to 1e6");
        });
        app_.add_option("--surface", arguments_.map_surface);
        real("--offset", kHighest_m, "metres above 0",
             [this](double m) { arguments_.map_offset_m = m; });
        real("--spacing", 1e6, "metres above 0",
             [this](double m) { arguments_.map_spacing_m = m; });
        app_.add_flag("--interaural", arguments_.map_interaural);
        app_.add_flag("--third-octaves", arguments_.third_octaves);
        // The limit of "scale" in scene files.
        real("--scale", 1e6, "metres per unit of the model, above 0",
             [this](double scale) { arguments_.model.scale = scale; });
        choice<bool>("--up", {{"y", true}, {"z", false}},
                     [this](bool y_up) { arguments_.model.y_is_up = y_up; });
    }

    void add_positions() {
        text("--position", [this](const std::string& value) {
            const Vec3 position = read_point("--position", value);
            arguments_.scene_changes.push_back(
                [position](Scene& scene) { set_listener_position(scene, position); });
        });
        app_.add_option("--source-position", source_positions_)->allow_extra_args(false);
    }

    // The limits are those of the scene file.
    void add_simulation() {
        std::vector<std::pair<std::string, Estimator>> estimators;
        for (const auto e :
             {Estimator::pt, Estimator::dpc_published, Estimator::dpc, Estimator::patch})
            estimators.emplace_back(estimator_name(e), e);
        choice<Estimator>("--estimator", estimators, simulation(&Simulation::estimator));
        choice<Quality>(
            "--quality",
            {{"draft", Quality::draft}, {"normal", Quality::normal}, {"fine", Quality::fine}},
            simulation(&Simulation::quality));
        integer<int>("--rays", 1, Simulation::kMaxRays,
                     [this, change = simulation(&Simulation::rays)](int n) {
                         arguments_.rays_given = true;
                         change(n);
                     });
        integer<int>("--order", 0, Simulation::kMaxOrder, simulation(&Simulation::order));
        integer<int>("--specular-order", 0, Simulation::kHighestSpecularOrder,
                     simulation(&Simulation::specular_order));
        real("--response-time", Simulation::kMaxResponseTime_s, "seconds from 0 to 3600",
             simulation(&Simulation::response_time_s), true);
        real("--patch-size", Simulation::kMaxLength_m, "metres above 0, at most 1e6",
             simulation(&Simulation::patch_size_m));
        real("--listener-radius", Simulation::kMaxLength_m, "metres above 0, at most 1e6",
             simulation(&Simulation::listener_radius_m));
        real("--frame-rate", Simulation::kMaxFrameRate_hz,
             "frames per second above 0, at most 1000", simulation(&Simulation::frame_rate_hz));
        const auto set_length = simulation(&Simulation::ir_length_s);
        text("--ir-length", [set_length](const std::string& value) {
            if (value == "auto") return set_length(std::optional<float>());
            set_length(std::optional(
                read_number("--ir-length", value, std::numeric_limits<float>::min(),
                            Simulation::kMaxIrLength_s, "auto, or seconds above 0, at most 10")));
        });
        integer<std::uint64_t>("--seed", 0, std::numeric_limits<std::uint64_t>::max(),
                               simulation(&Simulation::seed));
        integer<int>("--threads", 1, Simulation::kMaxThreads, simulation(&Simulation::threads));
        integer<int>("--memory-mb", 1, Simulation::kMaxMemory_mb,
                     simulation(&Simulation::memory_mb));
    }

    void add_sound() {
        PlaybackOptions& playback = arguments_.playback;
        std::vector<std::pair<std::string, OutputFormat>> outputs;
        for (const auto& [name, format] : kOutputFormats) outputs.emplace_back(name, format);
        choice<OutputFormat>("--output", outputs, [&](OutputFormat o) { playback.output = o; });
        integer<int>("--ambisonic-order", 1, kHighestAmbisonicOrder,
                     [&](int order) { playback.ambisonic_order = order; });
        app_.add_flag("--half-precision-tail", playback.half_precision_tail);
        text("--hrtf", [&](const std::string& file) {
            if (file.empty()) refuse_value("--hrtf", file, "a SOFA file");
            playback.hrtf = utf8_path(file);
        });
        text("--headphones", [&](const std::string& file) {
            if (file.empty()) refuse_value("--headphones", file, "a sound file");
            playback.headphones = utf8_path(file);
        });
        choice<SampleFormat>("--format",
                             {{"float", SampleFormat::float32},
                              {"pcm24", SampleFormat::pcm24},
                              {"pcm16", SampleFormat::pcm16}},
                             [&](SampleFormat f) { playback.format = f; });
        app_.add_flag("--no-dither{false}", playback.dither);
        integer<int>("--sample-rate", 8000, 192'000, [&](int hz) { playback.sample_rate_hz = hz; });
        text("--block", [&](const std::string& value) {
            constexpr int kMin = 16;
            constexpr int kMax = 8192;
            const std::string expected = "a power of two from 16 to 8192";
            playback.block = read_number("--block", value, kMin, kMax, expected);
            if ((playback.block & (playback.block - 1)) != 0)
                refuse_value("--block", value, expected);
        });
        real("--duration", 1e6, "seconds above 0, at most 1e6",
             [&](double s) { playback.duration_s = s; });
        text("--device", [&](const std::string& name) { playback.device = name; });
    }

    void add_window() {
        text("--osc", [this](const std::string& address) {
            check_osc_address(address);
            osc_.address = address;
        });
        text("--adm-origin", [this](const std::string& value) {
            osc_.adm_origin = read_point("--adm-origin", value);
        });
        real("--adm-radius", 1e6, "metres above 0, at most 1e6",
             [this](double m) { osc_.adm_radius_m = static_cast<float>(m); });
        app_.add_flag("--head-invert", osc_.head_invert);
        app_.add_flag("--no-window", no_window_);
        path("--scene-dir", arguments_.scene_dir);
        path("--screenshot", arguments_.screenshot);
        real("--after", 3600, "seconds above 0, at most 3600", [this](double s) {
            after_given_ = true;
            arguments_.screenshot_after_s = s;
        });
    }

    Arguments::Command command() {
        using Command = Arguments::Command;
        if (help_) {
            if (!words_.empty()) arguments_.help = words_[0];
            return Command::help;
        }
        if (version_) return Command::version;
        read_source_positions();
        Command word = Command::play;
        if (!words_.empty() && words_[0] == "materials") word = Command::materials;
        if (!words_.empty() && words_[0] == "info") word = Command::info;
        if (!words_.empty() && words_[0] == "check") word = Command::check;
        if (!words_.empty() && words_[0] == "import") word = Command::import;
        if (!words_.empty() && words_[0] == "map") word = Command::map;
        if (!words_.empty() && words_[0] == "report") word = Command::report;
        if (!words_.empty() && words_[0] == "analyse") return analyse_command();
        if (word == Command::materials) return materials_command();
        const std::size_t wanted = word == Command::play ? 1 : 2;
        if (list_devices_ && word == Command::play) return Command::list_devices;
        if (words_.size() < wanted)
            throw InputError("no SCENE given; expected aula SCENE [options]");
        if (words_.size() > wanted)
            throw InputError("\"" + words_[wanted] +
                             "\" is one argument too many; expected one SCENE");
        arguments_.scene = utf8_path(words_.back());
        arguments_.window = !no_window_;
        if (after_given_ && !arguments_.screenshot)
            throw InputError("--after: is used without --screenshot; expected both");
        const char* const alone = osc_.adm_origin     ? "--adm-origin"
                                  : osc_.adm_radius_m ? "--adm-radius"
                                  : osc_.head_invert  ? "--head-invert"
                                                      : nullptr;
        if (alone != nullptr && osc_.address.empty())
            throw InputError(std::string(alone) + ": is used without --osc; expected both");
        if (!osc_.address.empty()) arguments_.osc = osc_;
        if (arguments_.screenshot && no_window_)
            throw InputError(
                "--screenshot cannot be combined with --no-window; expected one or the other");
        if (arguments_.screenshot && arguments_.screenshot->extension() != ".png")
            throw InputError("--screenshot: \"" + arguments_.screenshot->string() +
                             "\" is not the name of a PNG file; expected FILE.png");
        read_documents(word);
        if (word != Command::play) return word;

        check_headphones();
        arguments_.report = report_.has_value();
        if (report_ && !report_->empty()) arguments_.report_json = *report_;
        const bool measures = arguments_.ir || arguments_.echogram || arguments_.report;
        if (offline_ && measures)
            throw InputError(
                "--offline cannot be combined with --ir, --echogram or --report; expected one or "
                "the other");
        if (arguments_.ir && arguments_.playback.format != SampleFormat::float32)
            throw InputError("--format: --ir writes float; expected no --format or float");
        if (!arguments_.playback.dither && arguments_.playback.format == SampleFormat::float32)
            throw InputError(
                "--no-dither: float is not dithered; expected --format pcm24 or pcm16");
        if (offline_) arguments_.offline = *offline_;
        return measures ? Command::measure : offline_ ? Command::render : Command::play;
    }

    void check_headphones() const {
        if (arguments_.playback.headphones.empty()) return;
        if (arguments_.playback.output != OutputFormat::binaural)
            throw InputError("--headphones: is for binaural output; expected no --output");
        if (!arguments_.ir && (arguments_.echogram || report_))
            throw InputError(
                "--headphones: is not used by --echogram and --report; expected --ir, too");
    }

    /// Parses `materials`, `materials list`, `materials WORD` and `materials show NAME`.
    Arguments::Command materials_command() {
        const std::string what = words_.size() > 1 ? words_[1] : "list";
        if (what == "show" && words_.size() == 3) {
            arguments_.material = words_[2];
        } else if (what == "show" || words_.size() > 2) {
            throw InputError("materials: \"" + words_.back() +
                             "\" is not usable; expected list, a word, or show and the name of a "
                             "material");
        } else if (what != "list") {
            arguments_.material_word = what;
        }
        return Arguments::Command::materials;
    }

    /// Parses `analyse FILE.wav...`.
    Arguments::Command analyse_command() {
        if (words_.size() < 2)
            throw InputError("analyse: no file given; expected aula analyse FILE.wav");
        for (std::size_t i = 1; i < words_.size(); ++i)
            arguments_.responses.push_back(utf8_path(words_[i]));
        for (const CLI::Option* const option : app_.get_options()) {
            const std::string name = option->get_name();
            if (option->count() > 0 && name.starts_with("--") && name != "--out" &&
                name != "--third-octaves" && name != "--speech-level" && name != "--noise-level" &&
                name != "--quiet")
                throw InputError(name + ": is not used by aula analyse; expected no such option");
        }
        if (arguments_.noise_db && !arguments_.speech_db)
            throw InputError("--noise-level: is used without --speech-level; expected both");
        if (!out_) return Arguments::Command::analyse;
        arguments_.out = *out_;
        if (out_->extension() != ".csv" && out_->extension() != ".json")
            throw InputError("--out: \"" + out_->string() +
                             "\" is not usable; expected FILE.csv or FILE.json");
        return Arguments::Command::analyse;
    }

    /// Takes the options of the commands `map`, `report` and `import`; refuses them for others.
    void read_documents(Arguments::Command word) {
        using Command = Arguments::Command;
        const auto refuse = [&](Command owner, const char* command, const char* name) {
            if (word != owner && app_.get_option(name)->count() > 0)
                throw InputError(std::string(name) + ": is used without " + command +
                                 "; expected aula " + command);
        };
        if (word != Command::import) refuse(Command::map, "map", "--out");
        const bool has_parameters = word == Command::analyse || word == Command::map ||
                                    word == Command::report || (word == Command::play && report_);
        if (arguments_.third_octaves && !has_parameters)
            throw InputError(
                "--third-octaves: is used without parameters; expected --report, or aula analyse, "
                "map or report");
        for (const char* const name :
             {"--height", "--surface", "--offset", "--spacing", "--interaural"})
            refuse(Command::map, "map", name);
        for (const char* const name : {"--scale", "--up"}) refuse(Command::import, "import", name);
        for (const char* const name : {"--html", "--json", "--receiver", "--measured", "--project",
                                       "--client", "--author", "--date"})
            refuse(Command::report, "report", name);
        refuse(Command::check, "check", "--strict");
        if (word == Command::map || word == Command::report)
            refuse_options_of_sound(word == Command::map ? "map" : "report");
        if (word == Command::import && out_) arguments_.out = *out_;
        if (word == Command::map) {
            if (!out_)
                throw InputError("map: has no --out; expected --out and the name of a folder");
            arguments_.out = *out_;
            const bool has_surface = app_.get_option("--surface")->count() > 0;
            if (has_surface && app_.get_option("--height")->count() > 0)
                throw InputError("--height: is used with --surface; expected one of them");
            if (!has_surface && app_.get_option("--offset")->count() > 0)
                throw InputError("--offset: is used without --surface; expected both");
        }
        if (word == Command::report) {
            if (!html_)
                throw InputError("report: has no --html; expected --html and the name of a file");
            arguments_.html = *html_;
            for (const std::string& text : receivers_) {
                const auto [name, position] = read_named_point("--receiver", text);
                for (const NamedReceiver& other : arguments_.receivers)
                    if (other.name == name)
                        throw InputError("--receiver: \"" + name +
                                         "\" is given twice; expected different names");
                arguments_.receivers.push_back({name, position});
            }
        }
    }

    /// Refuses the options of other outputs and of playback, which the commands `map` and `report`
    /// do not use.
    void refuse_options_of_sound(const std::string& command) const {
        for (const char* const name :
             {"--offline", "--ir", "--echogram", "--report", "--bin-ms", "--list-devices",
              "--screenshot", "--after", "--duration", "--output", "--format", "--sample-rate",
              "--no-dither", "--block", "--hrtf", "--headphones", "--device", "--osc",
              "--no-window"}) {
            if (app_.get_option(name)->count() > 0)
                throw InputError(std::string(name) + ": is not used by aula " + command +
                                 "; expected no such option");
        }
    }

    void read_source_positions() {
        for (const std::string& text : source_positions_) {
            const std::pair<std::string, Vec3> point = read_named_point("--source-position", text);
            arguments_.scene_changes.push_back(
                [name = point.first, position = point.second](Scene& scene) {
                    set_source_position(scene, name, position);
                });
        }
    }

    Arguments& arguments_;
    CLI::App app_;
    std::vector<std::string> words_;
    std::vector<std::string> source_positions_;
    std::optional<std::filesystem::path> offline_;
    std::optional<std::string> report_;
    std::optional<std::filesystem::path> out_;
    std::optional<std::filesystem::path> html_;
    std::vector<std::string> receivers_;
    std::vector<std::string> measured_;
    OscOptions osc_;
    bool no_window_ = false;
    bool after_given_ = false;
    bool version_ = false;
    bool help_ = false;
    bool list_devices_ = false;
};

}  // namespace

Arguments read_arguments(int argc, const char* const* argv) {
    Arguments arguments;
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    const bool asks_help = std::find_if(words.begin(), words.end(), [](const std::string& word) {
                               return word == "--help" || word == "-h";
                           }) != words.end();
    if (!words.empty() && words[0] == "dataset" && !asks_help) {
        arguments.command = Arguments::Command::dataset;
        arguments.dataset = read_dataset_arguments({words.begin() + 1, words.end()});
        return arguments;
    }
    Options(arguments).parse(argc, argv);
    return arguments;
}

}  // namespace aula
