#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "apps/aula/commands.h"
#include "apps/aula/outputs.h"
#include "apps/aula/terminal/interrupt.h"
#include "apps/aula/terminal/key_input.h"
#include "apps/aula/terminal/terminal.h"
#include "apps/aula/walker.h"
#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "apps/room/edit/scene_edits.h"
#include "apps/room/live/play_summary.h"
#include "apps/room/live/player.h"
#include "apps/room/live/reduction_reporter.h"
#include "apps/room/remote/osc_remote.h"
#include "aula/devices/device.h"
#include "aula/exception.h"
#ifdef AULA_HAS_WINDOW
#include "apps/window/window.h"
#endif

namespace aula {

namespace {

std::string level_text(float peak) {
    if (peak < 1e-5F) return "silent";
    return fixed_text(20 * std::log10(static_cast<double>(peak)), 1) + " dBFS";
}

/// Degrees 0 to 359, anticlockwise from x.
int heading_deg(const Pose& pose) {
    const long turned_deg = std::lround(pose.yaw_rad * 180 / std::numbers::pi_v<float>);
    return static_cast<int>(((turned_deg % 360) + 360) % 360);
}

/// The number of paths of the direct sound around edges and through walls.
std::string direct_paths_text(const FrameStatistics& frame) {
    std::string text;
    if (frame.bent_paths > 0) text += formatted("  %zu bent", frame.bent_paths);
    if (frame.wall_paths > 0) text += formatted("  %zu through walls", frame.wall_paths);
    return text;
}

std::string status_text(const PlayStatus& s) {
    const auto coordinate = [](float x) { return fixed_text(static_cast<double>(x), 1); };
    const Vec3 at = s.listener.position;
    return formatted("%6.1f s  (", s.time_s) + coordinate(at.x) + ", " + coordinate(at.y) + ", " +
           coordinate(at.z) +
           formatted(") m  %3d deg  frame %.1f/%.1f ms  ", heading_deg(s.listener), s.frame_mean_ms,
                     s.frame_worst_ms) +
           (s.rays < s.full_rays ? formatted("%d rays  ", s.rays) : std::string()) +
           formatted("audio %.0f %%  underruns %llu  ", 100 * s.load,
                     static_cast<unsigned long long>(s.underruns)) +
           level_text(s.peak) + direct_paths_text(s.frame);
}

const char* text_of(UnderrunCause cause) {
    switch (cause) {
        case UnderrunCause::rendering:
            return "caused by Aula: rendering took too long";
        case UnderrunCause::scheduling:
            return "caused by the machine: the audio thread was scheduled late";
        case UnderrunCause::sound_system:
            break;
    }
    return "caused by the audio server";
}

/// Prints the duration, the latency and the underruns.
void print_summary(const PlayStatus& s) {
    std::fprintf(stderr, "%s\n%s\n", play_summary(s).c_str(), latency_summary(s.latency).c_str());
    if (const std::string text = reduction_text(s); !text.empty())
        std::fprintf(stderr, "this machine %s\n", text.c_str());
    if (s.muted_samples > 0)
        std::fprintf(stderr, "aula: warning: %s\n", muted_text(s.muted_samples).c_str());
    for (const Underrun& underrun : s.first_underruns)
        std::fprintf(stderr, "underrun at %.2f s, %s\n", underrun.time_s, text_of(underrun.cause));
    if (s.underruns > s.first_underruns.size())
        std::fprintf(stderr, "%zu more underruns; of all underruns %llu caused by Aula\n",
                     static_cast<std::size_t>(s.underruns) - s.first_underruns.size(),
                     static_cast<unsigned long long>(s.rendering_underruns));
}

/// Prints changes of the output device's state and of the sound, one line each.
class DeviceReporter {
 public:
    explicit DeviceReporter(const Player& player)
        : name_(player.device().name), rate_hz_(player.sample_rate_hz()) {}

    void report(const PlayStatus& status, StatusLine& line) {
        if (!status.realtime && !reported_priority_) {
            reported_priority_ = true;
            say(line,
                "the audio thread runs without real-time priority, which the system refused "
                "(\"ulimit -r 70\" or membership of the group audio allows it)");
        }
        if (status.muted_samples > 0 && !reported_muted_) {
            reported_muted_ = true;
            say(line, "samples that are not finite, or beyond 1e6, are muted");
        }
        const std::string silent = silent_text(status.silent_pairs, status.sources.size());
        if (silent != silent_) {
            if (status.silent_pairs > 0 || !silent_.empty()) say(line, silent);
            silent_ = silent;
        }
        const bool playing = status.device == DeviceState::playing;
        if (playing == played_) return;
        played_ = playing;
        std::string text = "\" is available again";
        if (!playing) {
            text = "\" or its server is lost; waiting for it for ";
            text += std::to_string(std::lround(AudioDevice::kReconnectTimeout_s)) + " s";
        }
        if (playing && status.sample_rate_hz != rate_hz_) {
            rate_hz_ = status.sample_rate_hz;
            text += ", at " + std::to_string(std::lround(rate_hz_)) + " Hz";
        }
        say(line, "the output device \"" + name_ + text);
    }

 private:
    static void say(StatusLine& line, const std::string& text) {
        line.clear();
        std::fprintf(stderr, "aula: warning: %s\n", printable_line(text).c_str());
    }

    std::string name_;
    double rate_hz_;
    bool reported_priority_ = false;
    bool reported_muted_ = false;
    std::string silent_;  ///< the last text
    bool played_ = true;
};

constexpr const char* kKeysText =
    "w/s or up/down: walk, a/d: step sideways, left/right: turn, q: quit, ?: these keys";

/// Replaces materials as requested by OSC messages.
void replace_materials(OscRemote& remote, Scene& scene, Player& player,
                       const PlaybackOptions& playback) {
    for (const auto& [from, to] : remote.take_materials()) {
        auto edited = with_material_replaced(scene, from, to);
        if (!edited) continue;
        scene = std::move(*edited);
        player.change(scene, playback);
    }
}

int play_in_terminal(const Arguments& arguments) {
    using Clock = std::chrono::steady_clock;
    constexpr int kKeyWait_ms = 20;
    constexpr std::chrono::milliseconds kStatusInterval{100};

    LoadedScene loaded = read_scene_file(arguments.scene, arguments);
    Scene& scene = loaded.scene;
    change_scene(scene, arguments);
    PlaybackOptions playback = arguments.playback;
    playback.rays_fall = !arguments.rays_given;
    // What is moved from outside does not end with the path of the scene.
    if (arguments.osc && !playback.duration_s) playback.duration_s = PlaybackOptions::kUnlimited_s;
    Player player(scene, playback);
    warn(player.warnings(), arguments.quiet);
    std::optional<OscRemote> remote;
    if (arguments.osc) {
        remote.emplace(*arguments.osc, player, scene);
        if (!arguments.quiet) std::fprintf(stderr, "%s\n", remote->region_text().c_str());
    }
    PlayStatus status = player.status();
    {
        StatusLine line(!arguments.quiet);
        const KeyInput keys;
        const bool walks = keys.active() && !scene.listener.path;
        if (line.visible())
            std::fprintf(stderr, "playing on %s; %s\n",
                         printable_line(player.device().name).c_str(),
                         walks ? kKeysText : "q or Ctrl-C: quit");
        DeviceReporter device_reporter(player);
        ReductionReporter reductions("--rays and --ir-length set them");
        Walker walker(scene.listener.pose_at(0));
        Clock::time_point walked = Clock::now();
        Clock::time_point next_status = walked;
        while (!status.finished && interrupt_signal() == 0) {
            const auto key = keys.read(kKeyWait_ms);
            if (key == Key::quit) break;
            if (key == Key::help && line.visible()) {
                line.clear();
                std::fprintf(stderr, "%s\n", kKeysText);
            }
            const Clock::time_point now = Clock::now();
            if (walks && !remote) {
                if (key) walker.press(*key);
                player.move_listener(
                    walker.advance(std::chrono::duration<double>(now - walked).count()));
            }
            walked = now;
            if (now >= next_status) {
                next_status = now + kStatusInterval;
                status = player.status();
                if (!arguments.quiet) {
                    device_reporter.report(status, line);
                    if (const auto text = reductions.take(status, status.time_s)) {
                        line.clear();
                        warn({"this machine " + *text}, false);
                    }
                }
                line.show(status_text(status));
                if (remote) replace_materials(*remote, scene, player, playback);
            }
        }
        status = player.status();
    }
    if (!arguments.quiet) print_summary(status);
    return interrupt_signal() != 0 ? interrupted_status() : 0;
}

/// The scene files of a folder, sorted by name. Throws InputError if there is none.
std::vector<std::filesystem::path> scenes_in(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".json" && entry.is_regular_file(error) &&
            !is_manifest(entry.path()))
            files.push_back(entry.path());
    if (files.empty())
        throw InputError(
            "--scene-dir", "",
            "no scene in \"" + folder.string() + "\"; expected a folder with scene files");
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

#ifdef AULA_HAS_WINDOW

namespace {

int play_in_window(const Arguments& arguments, const std::vector<std::filesystem::path>& scenes) {
    WindowOptions options;
    options.scene_file = arguments.scene;
    options.playback = arguments.playback;
    options.rays_given = arguments.rays_given;
    options.load = [&](const std::filesystem::path& file) {
        return read_scene_file(file, arguments);
    };
    options.change = [&](Scene& scene) {
        change_scene(scene, arguments);
        check_outputs(arguments, scene);
    };
    options.scenes = scenes;
    options.osc = arguments.osc;
    options.screenshot = arguments.screenshot;
    options.screenshot_after_s = arguments.screenshot_after_s;
    options.warn = [&](const std::string& warning) { warn({warning}, arguments.quiet); };
    options.keeps_state = !arguments.screenshot && std::getenv("AULA_NO_STATE") == nullptr;
    options.interrupted = [] { return interrupt_signal() != 0; };
    const PlayStatus status = show_window(options);
    if (!arguments.quiet && !arguments.screenshot) print_summary(status);
    return interrupt_signal() != 0 ? interrupted_status() : 0;
}

}  // namespace

#endif

int play(const Arguments& arguments) {
    std::vector<std::filesystem::path> scenes;
    if (arguments.scene_dir) scenes = scenes_in(*arguments.scene_dir);
#ifdef AULA_HAS_WINDOW
    if (arguments.window && window_possible()) return play_in_window(arguments, scenes);
#endif
    if (arguments.screenshot)
        throw InputError("--screenshot", "", "no window can be opened; expected a display");
    return play_in_terminal(arguments);
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

}  // namespace aula
