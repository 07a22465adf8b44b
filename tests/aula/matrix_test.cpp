#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "apps/aula/arguments/arguments.h"
#include "apps/room/live/player.h"
#include "apps/room/offline/measurement_text.h"
#include "apps/room/offline/offline.h"
#include "aula/engine/scene_file.h"
#include "aula/measurement.h"
#include "tests/aula/matrix_case.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

// Random valid scenes and settings, each in a separate process: a case that hangs or crashes is
// reported with its seed and command line, and the other cases continue.
//
// AULA_MATRIX_CASES: number of cases (100). AULA_MATRIX_SEED: first seed (1). With
// AULA_MATRIX_CASES=1 the files of the case are kept.

namespace {

using namespace aula;
using namespace aula::test;
using Clock = std::chrono::steady_clock;

long environment(const char* name, long otherwise) {
    const char* const text = std::getenv(name);
    return text != nullptr ? std::strtol(text, nullptr, 10) : otherwise;
}

void require(bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error(what);
}

/// Requires a duration in [min_s, max_s], the case's channels, finite samples and, if expected,
/// sound. Throws.
void check_sound(const std::filesystem::path& file, const MatrixCase& test, double min_s,
                 double max_s) {
    const SoundInfo info = sound_info(file);
    const auto length = static_cast<double>(info.samples);
    std::ostringstream found;
    found << file.filename().string() << ": " << info.samples << " samples in " << info.channels
          << " channels; expected " << min_s * test.sample_rate_hz << " to "
          << max_s * test.sample_rate_hz << " of " << test.channels;
    // Rounded to a sample.
    require(length >= std::floor(min_s * test.sample_rate_hz) &&
                length <= std::ceil(max_s * test.sample_rate_hz) && info.channels == test.channels,
            found.str());
    if (info.samples == 0) return;
    const SoundClip clip = read_sound(file, info.sample_rate_hz);
    for (const std::string& warning : clip.warnings)
        require(warning.find("not numbers") == std::string::npos, warning);
    const bool sounds = std::any_of(clip.samples.begin(), clip.samples.end(),
                                    [](float sample) { return sample != 0; });
    require(sounds || !test.must_be_heard, file.filename().string() + ": is silent");
}

void render(const Arguments& arguments, const Scene& scene, const MatrixCase& test) {
    require(render_offline(scene, arguments.playback, arguments.offline).has_value(),
            "rendering was stopped");
    check_sound(arguments.offline, test, test.duration_s,
                test.duration_given ? test.duration_s : test.longest_s);
    // The bytes are independent of the number of threads.
    if (scene.simulation.seed % 4 != 0) return;
    Scene other = scene;
    other.simulation.threads = scene.simulation.threads == 1 ? 3 : 1;
    const std::string first = read_file(arguments.offline);
    require(render_offline(other, arguments.playback, arguments.offline).has_value(),
            "rendering was stopped");
    require(read_file(arguments.offline) == first, "other bytes with another number of threads");
}

void check_finite(const nlohmann::json& value) {
    for (const auto& item : value) {
        if (item.is_structured()) check_finite(item);
        if (item.is_number()) require(std::isfinite(item.get<double>()), "report: not finite");
    }
}

void measure_case(const Arguments& arguments, const Scene& scene, const MatrixCase& test) {
    const auto measurement = measure(scene, {.frames = arguments.frames});
    require(measurement.has_value(), "measuring was stopped");
    double energy = 0;
    for (const EnergyResponse& response : measurement->responses)
        for (std::size_t band = 0; band < kBandCount; ++band)
            energy += static_cast<double>(response.total(band));
    require(std::isfinite(energy) && energy >= 0, "the energy is not finite");
    require(energy > 0 || !test.must_be_heard, "no energy");
    if (arguments.ir) {
        const ImpulseResponses responses(*measurement, arguments.playback);
        for (std::size_t s = 0; s < scene.sources.size(); ++s) {
            const auto channels = responses.response(s);
            require(static_cast<int>(channels.size()) == test.channels, "channels of the response");
            double sum = 0;
            for (const auto& channel : channels) {
                require(static_cast<double>(channel.size()) >=
                            std::floor(measurement->length_s * test.sample_rate_hz),
                        "the response is too short");
                for (const float x : channel)
                    sum += static_cast<double>(x) * static_cast<double>(x);
            }
            require(std::isfinite(sum), "the response is not finite");
            require(sum > 0 || !test.must_be_heard, "the response is silent");
        }
    }
    if (arguments.echogram) {
        const std::string csv = echogram_csv(scene, *measurement, arguments.bin_s);
        require(csv.find("nan") == std::string::npos && csv.find("inf") == std::string::npos,
                "the echogram is not finite");
    }
    if (arguments.report) {
        // The parser refuses NaN.
        const auto report = nlohmann::json::parse(report_json(*measurement));
        require(report["sources"].size() == scene.sources.size(), "sources of the report");
        check_finite(report);
    }
}

/// Plays and records the scene while controls and estimator change.
void play(const Arguments& arguments, const Scene& scene, const MatrixCase& test,
          std::uint64_t seed, const std::filesystem::path& folder) {
    const auto file = folder / "heard.wav";
    {
        Player player(scene, arguments.playback);
        player.record(file);
        ViewRequest request;
        request.columns = 50;
        request.lines = seed % 3 == 0 ? 20 : 0;
        request.patches = seed % 5 == 0;
        player.watch(request);
        bool changed = seed % 3 != 1;
        for (int turn = 0; !player.status().finished; ++turn) {
            if (turn % 7 == 3) player.move_listener(scene.listener.pose_at(0.1 * turn));
            if (turn % 11 == 5) {
                player.adjust([&](PlayControls& controls, const Pose&) {
                    controls.sources.resize(scene.sources.size());
                    controls.sources[0].gain_db = -static_cast<float>(turn % 5);
                });
            }
            if (!changed) {
                Scene other = scene;
                other.simulation.estimator = seed % 2 == 0 ? Estimator::patch : Estimator::dpc;
                player.change(other, arguments.playback);
                changed = true;
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        require(player.status().change_error.empty(), player.status().change_error);
        player.stop_recording();
        require(player.monitor_status().error.empty(), player.monitor_status().error);
    }
    // The recording starts after playback and stops after its end: only its content is checked.
    check_sound(file, test, 0, 1e9);
}

/// Runs a case in this process. Throws if a result is wrong.
void run(std::uint64_t seed, const std::filesystem::path& folder) {
    const MatrixCase test = make_case(seed, folder);
    std::vector<const char*> words;
    for (const std::string& word : test.command) words.push_back(word.c_str());
    const Arguments arguments = read_arguments(static_cast<int>(words.size()), words.data());
    Scene scene = load_scene(arguments.scene).scene;
    for (const auto& change : arguments.scene_changes) change(scene);
    switch (arguments.command) {
        case Arguments::Command::render:
            return render(arguments, scene, test);
        case Arguments::Command::measure:
            return measure_case(arguments, scene, test);
        default:
            return play(arguments, scene, test, seed, folder);
    }
}

/// A case that runs in a separate process.
class CaseProcess {
 public:
    explicit CaseProcess(std::uint64_t seed) : seed_(seed) {
        const rlim_t limit =
            static_cast<rlim_t>(std::ceil(make_case(seed, folder_.path()).cpu_limit_s));
        pid_ = fork();
        if (pid_ < 0) throw std::runtime_error("no process");
        if (pid_ > 0) return;
        const rlimit cpu{limit, limit};
        const rlimit no_core{0, 0};
        setrlimit(RLIMIT_CPU, &cpu);
        setrlimit(RLIMIT_CORE, &no_core);
        int status = 0;
        try {
            run(seed, folder_.path());
        } catch (const std::exception& thrown) {
            folder_.write("error", thrown.what());
            status = 1;
        }
        _exit(status);
    }

    /// True if the process has ended. Kills a process whose threads are in a deadlock.
    bool ended() {
        int status = 0;
        rusage used{};
        if (wait4(pid_, &status, WNOHANG, &used) != pid_) {
            end_if_stuck();
            return false;
        }
        const auto seconds = [](const timeval& t) {
            return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
        };
        cpu_s = seconds(used.ru_utime) + seconds(used.ru_stime);
        memory_mb = used.ru_maxrss / 1024;
        if (stuck_) {
            error = "deadlock: all threads slept for a minute";
        } else if (WIFSIGNALED(status)) {
            error = std::string("ended by ") + strsignal(WTERMSIG(status)) + " after " +
                    std::to_string(cpu_s) + " s of CPU";
        } else if (WEXITSTATUS(status) != 0) {
            error = read_file(folder_.path() / "error");
            if (error.empty()) error = "exit status " + std::to_string(WEXITSTATUS(status));
        }
        return true;
    }

    std::uint64_t seed() const { return seed_; }

    /// The failure, and the command to reproduce it.
    std::string failure() const {
        std::string text = "seed " + std::to_string(seed_) + ": " + error + "\n ";
        const TemporaryFolder again;
        for (const std::string& word : make_case(seed_, again.path()).command)
            text += " '" + word + "'";
        return text + "\n  again: AULA_MATRIX_CASES=1 AULA_MATRIX_SEED=" + std::to_string(seed_) +
               " test_matrix\n" + read_file(again.path() / "scene.json");
    }

    std::string error;  ///< empty: passed
    double cpu_s = 0;
    long memory_mb = 0;

 private:
    /// True if a thread is running, ready, or waiting for the disk.
    bool works() const {
        const std::string tasks = "/proc/" + std::to_string(pid_) + "/task";
        std::error_code ended;
        for (const auto& task : std::filesystem::directory_iterator(tasks, ended)) {
            const std::string stat = read_file(task.path() / "stat");
            const std::size_t name_end = stat.rfind(')');
            if (name_end == std::string::npos || name_end + 2 >= stat.size()) continue;
            if (stat[name_end + 2] == 'R' || stat[name_end + 2] == 'D') return true;
        }
        return false;
    }

    /// Kills a process whose threads have all slept for a minute.
    void end_if_stuck() {
        constexpr std::chrono::seconds kLongest{60};
        clockid_t clock{};
        timespec used{};
        if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return;
        const double now_s =
            static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
        constexpr double kSome_s = 0.05;
        if (now_s > seen_s_ + kSome_s || works()) {
            seen_s_ = now_s;
            seen_ = Clock::now();
        } else if (Clock::now() > seen_ + kLongest) {
            stuck_ = true;
            kill(pid_, SIGKILL);
        }
    }

    std::uint64_t seed_;
    TemporaryFolder folder_;
    pid_t pid_ = -1;
    bool stuck_ = false;
    double seen_s_ = 0;
    Clock::time_point seen_ = Clock::now();
};

}  // namespace

TEST_CASE("Random scenes and settings are rendered, measured and played without an error") {
    const auto cases = environment("AULA_MATRIX_CASES", 100);
    const auto first = static_cast<std::uint64_t>(environment("AULA_MATRIX_SEED", 1));
    if (cases == 1) {
        std::string folder = "matrix-" + std::to_string(first);
        std::filesystem::create_directories(folder);
        for (const std::string& word : make_case(first, folder).command) std::cout << word << ' ';
        std::cout << std::endl;
    }
    // sigtimedwait() below waits for SIGCHLD.
    sigset_t child;
    sigemptyset(&child);
    sigaddset(&child, SIGCHLD);
    sigprocmask(SIG_BLOCK, &child, nullptr);

    const std::size_t at_a_time = std::max(1U, std::thread::hardware_concurrency());
    std::vector<std::unique_ptr<CaseProcess>> running;
    double cpu_s = 0;
    double worst_cpu_s = 0;
    long worst_memory_mb = 0;
    long begun = 0;
    while (begun < cases || !running.empty()) {
        while (begun < cases && running.size() < at_a_time)
            running.push_back(
                std::make_unique<CaseProcess>(first + static_cast<std::uint64_t>(begun++)));
        constexpr timespec kLook{.tv_sec = 2, .tv_nsec = 0};
        sigtimedwait(&child, nullptr, &kLook);
        std::erase_if(running, [&](const auto& process) {
            if (!process->ended()) return false;
            cpu_s += process->cpu_s;
            worst_cpu_s = std::max(worst_cpu_s, process->cpu_s);
            worst_memory_mb = std::max(worst_memory_mb, process->memory_mb);
            if (process->error.empty()) {
                SUCCEED();
            } else {
                FAIL_CHECK(process->failure());
            }
            return true;
        });
    }
    std::cout << cases << " cases from seed " << first << ": " << cpu_s << " s of CPU, at most "
              << worst_cpu_s << " s and " << worst_memory_mb << " MB\n";
}
