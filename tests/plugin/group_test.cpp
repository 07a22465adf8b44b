#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/plugin/plugin_host.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait.h"

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;
namespace fs = std::filesystem;

/// A free field: a click arrives once.
const char* const kFreeField = R"({"aula": 1,
    "sources": [{"name": "s", "position": [3.432, 0, 0], "signal": "impulse"}],
    "listener": {"position": [0, 0, 0]}})";

StoredState state_with(const std::string& scene) {
    return {{kScene, {LV2_ATOM__Path, {scene.c_str(), scene.c_str() + scene.size() + 1}}}};
}

std::unique_ptr<PluginHost> make_host(int group, OutputFormat layout = OutputFormat::binaural) {
    auto host = std::make_unique<PluginHost>(layout);
    host->set(Control::room_group, static_cast<float>(group));
    return host;
}

std::unique_ptr<PluginHost> make_running_host(int group) {
    auto host = make_host(group);
    host->set(Control::quality, 0);
    host->activate();
    return host;
}

Channels bounce(int group, std::span<const float> input, std::size_t size) {
    const auto host = make_host(group);
    host->set_freewheel(1);
    host->set(Control::quality, 0);
    host->activate();
    return host->run(input, {size});
}

/// Runs hosts in turn for a while, as a program with an audio device does.
void play(const std::vector<PluginHost*>& hosts, std::chrono::milliseconds duration) {
    const auto end = std::chrono::steady_clock::now() + duration;
    const std::vector<float> input = noise(480);
    while (std::chrono::steady_clock::now() < end) {
        for (PluginHost* const host : hosts) host->run(input, {480});
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

/// The RMS of the sound of steady noise.
float level_db(PluginHost& host) {
    const Channels output = host.run(noise(48000), {480});
    double sum = 0;
    for (std::size_t n = 24000; n < output[0].size(); ++n)
        sum += double{output[0][n]} * double{output[0][n]};
    return static_cast<float>(10 * std::log10(sum / 24000));
}

/// Plays until a condition holds, for at most two minutes.
template <typename Condition>
bool play_until(const std::vector<PluginHost*>& hosts, Condition&& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        play(hosts, std::chrono::milliseconds(50));
    }
    return true;
}

/// Memory of the process that is resident, MB, without what the heap keeps for the next request.
double resident_mb() {
    malloc_trim(0);
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    file >> pages >> pages;
    return pages * 4096e-6;
}

/// Plays until the caches that all instances share hardly grow, for at most 60 s. Returns the
/// resident memory in MB.
double settled_mb(const std::vector<PluginHost*>& hosts) {
    double before_mb = resident_mb();
    for (int second = 0; second < 60; ++second) {
        play(hosts, std::chrono::seconds(1));
        const double now_mb = resident_mb();
        if (now_mb < before_mb + 0.5) return now_mb;
        before_mb = now_mb;
    }
    return before_mb;
}

/// Threads of the process. Those of Embree's scheduler end some time after their last scene, that
/// which finds the modes of a room after some seconds.
int thread_count() {
    const std::filesystem::directory_iterator threads("/proc/self/task");
    return static_cast<int>(std::distance(begin(threads), end(threads)));
}

/// The same once it has not changed for two seconds, for at most a minute: the modes are found.
int settled_threads(const std::vector<PluginHost*>& hosts) {
    int count = thread_count();
    int same = 0;
    for (int second = 0; second < 60 && same < 2; ++second) {
        play(hosts, std::chrono::seconds(1));
        const int now = thread_count();
        same = now == count ? same + 1 : 0;
        count = now;
    }
    return count;
}

int processors() { return static_cast<int>(std::thread::hardware_concurrency()); }

}  // namespace

TEST_CASE("In a group a share of the room moves the source of an instance") {
    const TemporaryFolder folder;
    const std::string file = folder.write("room.json", R"({"aula": 1,
        "geometry": [{"box": [9, 7, 3], "material": "brick"}],
        "sources": [{"position": [6, 3.5, 1.5]}], "listener": {"position": [3.5, 3.5, 1.5]},
        "simulation": {"rays": 200, "ir_length_s": 0.3}})");
    const auto host = make_host(1, OutputFormat::foa);
    host->restore(state_with(file));
    for (const Control part : {Control::early, Control::late}) host->set(part, 0);
    host->activate();
    const auto distance_m = [&] {
        std::vector<float> click(2400);
        click[0] = 1;
        const Channels output = host->run(click, {480});
        const auto loudest = std::max_element(output[0].begin(), output[0].end());
        return static_cast<double>(loudest - output[0].begin()) / 48000 * 343.2;
    };
    // The filters of the air delay by some tenths of a millisecond.
    const auto is_at = [&](double m) { return std::abs(distance_m() - m) < 0.3; };
    CHECK(play_until({host.get()}, [&] { return is_at(2.5); }));
    host->set(Control::source_room_x, 1);
    CHECK(play_until({host.get()}, [&] { return is_at(5.4); }));
}

TEST_CASE("Instances of a group share threads and memory") {
    constexpr std::size_t kInstances = 8;
    using Formats = std::array<OutputFormat, 2>;
    const Formats formats = GENERATE(Formats{OutputFormat::binaural, OutputFormat::foa},
                                     Formats{OutputFormat::toa, OutputFormat::toa});
    // On a busy machine frames queue up, and an instance holds more filters.
    constexpr int kAttempts = 3;
    // Third order takes 32 to 36 MB, more if frames queue up in all attempts.
    constexpr double kMost_mb = 45;
    double least_mb = std::numeric_limits<double>::infinity();
    for (int attempt = 0; attempt < kAttempts && least_mb >= kMost_mb; ++attempt) {
        std::vector<std::unique_ptr<PluginHost>> hosts;
        std::vector<PluginHost*> all;
        const auto add = [&] {
            hosts.push_back(make_host(1, formats[hosts.size() % 2]));
            hosts.back()->set(Control::source_y, 1 + 0.5F * static_cast<float>(hosts.size()));
            hosts.back()->activate();
            all.push_back(hosts.back().get());
        };
        add();
        const double first_mb = settled_mb(all);
        while (all.size() < kInstances) add();
        least_mb = std::min(least_mb, (settled_mb(all) - first_mb) / (kInstances - 1));
        CHECK(eventually([] { return thread_count() <= processors() + 2; }));
        for (PluginHost* const host : all) CHECK(level_db(*host) > -60);
        all.clear();
        hosts.clear();
        CHECK(eventually([] { return thread_count() == 1; }));
    }
    INFO("each further instance: " << least_mb << " MB");
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    CHECK(least_mb < kMost_mb);
#endif
}

TEST_CASE("Instances that are on their own share the loader thread") {
    const int before = thread_count();
    const auto one = make_host(0, OutputFormat::foa);
    const auto other = make_host(0, OutputFormat::binaural);
    CHECK(thread_count() == before + 1);
}

TEST_CASE("A group renders the bytes of a single instance, also with several at the same time") {
    const std::vector<float> input = noise(9600);
    const Channels reference = bounce(0, input, 256);
    const auto live = make_running_host(2);
    CHECK((bounce(2, input, 100) == reference));
    std::vector<Channels> outputs(3);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < outputs.size(); ++i)
        threads.emplace_back([&, i] { outputs[i] = bounce(2, input, 64 + 100 * i); });
    play({live.get()}, std::chrono::milliseconds(200));
    for (std::thread& thread : threads) thread.join();
    for (const Channels& output : outputs) CHECK((output == reference));
}

TEST_CASE("In real time an instance of a group sounds as a single one does") {
    const auto own = make_running_host(0);
    const auto first = make_running_host(1);
    const auto second = make_running_host(1);
    second->set(Control::gain_db, -10);
    play({own.get(), first.get(), second.get()}, std::chrono::seconds(1));
    const float reference_db = level_db(*own);
    // The responses differ by the noise of a draft.
    CHECK(level_db(*first) == Approx(reference_db).margin(1));
    CHECK(level_db(*second) == Approx(reference_db - 10).margin(1));
    // Another layout, the instance that came first gone.
    const auto third = make_host(1, OutputFormat::foa);
    third->activate();
    first->deactivate();
    play({second.get(), third.get()}, std::chrono::milliseconds(200));
    CHECK(level_db(*second) == Approx(reference_db - 10).margin(1));
    CHECK(level_db(*third) > reference_db - 10);
}

TEST_CASE("Without its late part an instance of a group sounds as a single one does") {
    const auto own = make_running_host(0);
    const auto grouped = make_running_host(1);
    const std::vector<PluginHost*> all{own.get(), grouped.get()};
    play(all, std::chrono::milliseconds(500));
    const float whole_db = level_db(*own);
    for (PluginHost* const host : all) host->set(Control::late, 0);
    play(all, std::chrono::milliseconds(500));
    const float reference_db = level_db(*own);
    CHECK(reference_db < whole_db - 2);
    CHECK(level_db(*grouped) == Approx(reference_db).margin(1));
}

TEST_CASE("An instance of a group is heard from its own place, and the others from theirs") {
    const auto first = make_running_host(1);
    const auto second = make_running_host(1);
    const std::vector<PluginHost*> all{first.get(), second.get()};
    play(all, std::chrono::milliseconds(500));
    const float far_db = level_db(*first);
    // From 3.1 m to 0.25 m before the source.
    second->set(Control::listener_x, 6.25F);
    second->set(Control::listener_y, 4.25F);
    CHECK(play_until(all, [&] { return level_db(*second) > far_db + 6; }));
    CHECK(level_db(*first) == Approx(far_db).margin(1));
    // Back there they are together again, without the thread of a second room. Embree keeps one of
    // its own from the second scene on.
    const int threads = thread_count();
    second->set(Control::listener_x, first->get(Control::listener_x));
    second->set(Control::listener_y, first->get(Control::listener_y));
    CHECK(play_until(all, [&] { return thread_count() < threads; }));
    CHECK(play_until(all, [&] { return level_db(*second) < far_db + 1; }));
}

TEST_CASE("A moving source has the same pitch in a group as on its own") {
    const TemporaryFolder folder;
    const std::string file = folder.write("free.json", kFreeField);
    const auto own = make_host(0, OutputFormat::foa);
    const auto grouped = make_host(1, OutputFormat::foa);
    for (PluginHost* const host : {own.get(), grouped.get()}) {
        host->set(Control::source_y, 0);
        host->set(Control::source_z, 0);
        host->restore(state_with(file));
        host->activate();
    }
    constexpr double kSpeed_m_s = 60;
    constexpr double kTone_hz = 1000;
    constexpr std::size_t kBlock = 480;
    constexpr std::size_t kBlocks = 150;
    // By the position at the time of arrival it would be 825 Hz.
    const double expected_hz = kTone_hz / (1 + kSpeed_m_s / 343.2);
    // The frequency of a tone while the source moves away, in the last second.
    const auto heard_hz = [&](PluginHost& host) {
        const auto start = std::chrono::steady_clock::now();
        std::vector<float> tone(kBlock);
        std::vector<float> heard;
        for (std::size_t block = 0; block < kBlocks; ++block) {
            std::this_thread::sleep_until(start + block * std::chrono::milliseconds(10));
            for (std::size_t i = 0; i < kBlock; ++i)
                tone[i] =
                    static_cast<float>(std::sin(2 * std::numbers::pi * kTone_hz *
                                                static_cast<double>(block * kBlock + i) / 48000));
            host.set(Control::source_x,
                     static_cast<float>(5 + kSpeed_m_s * 0.01 * static_cast<double>(block)));
            const Channels output = host.run(tone, {kBlock});
            if (block >= kBlocks - 100)
                heard.insert(heard.end(), output[0].begin(), output[0].end());
        }
        int rises = 0;
        for (std::size_t n = 1; n < heard.size(); ++n) rises += heard[n - 1] < 0 && heard[n] >= 0;
        return rises;
    };
    // Late frames of a busy machine have another pitch.
    constexpr int kAttempts = 5;
    for (PluginHost* const host : {own.get(), grouped.get()}) {
        double nearest_hz = 0;
        for (int attempt = 0; attempt < kAttempts; ++attempt) {
            const double now_hz = heard_hz(*host);
            if (std::abs(now_hz - expected_hz) < std::abs(nearest_hz - expected_hz))
                nearest_hz = now_hz;
            if (std::abs(nearest_hz - expected_hz) < 8) break;
        }
        CHECK(nearest_hz == Approx(expected_hz).margin(8));
    }
}

TEST_CASE("Groups with different scenes do not mix, and a missing scene is the default room") {
    const TemporaryFolder folder;
    const std::string file = folder.write("free.json", kFreeField);
    const auto room = make_running_host(1);
    const auto free = make_host(1, OutputFormat::foa);
    free->restore(state_with(file));
    free->activate();
    play({room.get(), free.get()}, std::chrono::milliseconds(300));
    std::vector<float> click(48000);
    click[0] = 1;
    const auto late_peak = [&](PluginHost& host) {
        host.run(std::vector<float>(96000), {480});  // what rings
        const Channels output = host.run(click, {480});
        const auto louder = [](float a, float b) { return std::abs(a) < std::abs(b); };
        return std::abs(*std::max_element(output[0].begin() + 2000, output[0].end(), louder));
    };
    CHECK(late_peak(*free) < 1e-6F);
    CHECK(late_peak(*room) > 1e-5F);

    const std::string gone = "/nonexistent/hall.json";
    const int threads = settled_threads({room.get(), free.get()});
    const auto missing = make_host(1);
    missing->restore(state_with(gone));
    missing->activate();
    // It has joined the default room, whose modes may have been found meanwhile by a thread that
    // ends.
    CHECK(thread_count() <= threads);
    CHECK(late_peak(*missing) > 1e-5F);
    CHECK(play_until({missing.get()},
                     [&] { return missing->received(kStatus).find(gone) != std::string::npos; }));
    CHECK(missing->received(kScene) == gone);
}

TEST_CASE("An instance that joins a group after a mesh has changed hears the new mesh") {
    const TemporaryFolder folder;
    const auto write_mesh = [&](float half_m, int box) {
        std::ostringstream mesh;
        for (int corner = 0; corner < 8; ++corner)
            mesh << "v " << ((corner & 1) != 0 ? half_m : -half_m) << ' '
                 << ((corner & 2) != 0 ? half_m : -half_m) << ' '
                 << ((corner & 4) != 0 ? half_m : -half_m) << '\n';
        for (const char* const face :
             {"1 2 4 3", "5 6 8 7", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"})
            mesh << "f " << face << '\n';
        folder.write("room.obj", mesh.str());
        // As an editor that writes it a while later does.
        fs::last_write_time(folder.path() / "room.obj",
                            fs::file_time_type::clock::now() + std::chrono::seconds(box));
    };
    const fs::path file = folder.write("room.json", R"({"aula": 1,
        "geometry": [{"file": "room.obj", "material": "concrete"}],
        "simulation": {"waves": false},
        "sources": [{"name": "s", "position": [1, 0, 0], "signal": "impulse"}],
        "listener": {"position": [-1, 0, 0.5]}})");
    const auto make = [&] {
        auto host = make_host(1);
        host->set(Control::quality, 0);
        host->restore(state_with(file));
        host->activate();
        return host;
    };
    write_mesh(2, 0);
    const auto small = make();
    const int threads = thread_count();
    const auto same = make();
    CHECK(thread_count() == threads);
    write_mesh(8, 1);
    const auto large = make();
    const std::vector<PluginHost*> all{small.get(), same.get(), large.get()};
    play(all, std::chrono::milliseconds(500));
    const float small_db = level_db(*small);
    CHECK(level_db(*same) == Approx(small_db).margin(1));
    CHECK(level_db(*large) < small_db - 6);
    // The path is set again.
    same->send_path(kScene, file);
    CHECK(play_until(all, [&] { return level_db(*same) < small_db - 6; }));
}

TEST_CASE("Instances come and go in any order and on any thread while others play") {
    const TemporaryFolder folder;
    const std::string file = folder.write("free.json", kFreeField);
    const int before = thread_count();
    {
        const auto steady = make_running_host(1);
        std::atomic<int> active = 3;
        std::vector<std::thread> threads;
        std::atomic<int> failures = 0;
        for (unsigned t = 0; t < 3; ++t) {
            threads.emplace_back([&, t] {
                try {
                    std::minstd_rand random(t + 1);
                    std::vector<std::unique_ptr<PluginHost>> hosts;
                    for (int step = 0; step < 6; ++step) {
                        if (hosts.size() < 2 || random() % 2 == 0) {
                            hosts.push_back(
                                make_host(static_cast<int>(random() % 3), OutputFormat::foa));
                            if (random() % 4 != 0) hosts.back()->restore(state_with(file));
                            hosts.back()->set(Control::quality, 0);
                            hosts.back()->set_freewheel(random() % 4 == 0 ? 1.0F : 0.0F);
                            hosts.back()->activate();
                        } else {
                            hosts.erase(hosts.begin() +
                                        static_cast<std::ptrdiff_t>(random() % hosts.size()));
                        }
                        if (random() % 2 == 0 && !hosts.empty())
                            hosts[0]->set(Control::room_group, static_cast<float>(random() % 3));
                        for (const auto& host : hosts) host->run(noise(960), {480});
                    }
                } catch (const std::exception&) {
                    ++failures;
                }
                --active;
            });
        }
        while (active > 0) play({steady.get()}, std::chrono::milliseconds(20));
        for (std::thread& thread : threads) thread.join();
        CHECK(failures == 0);
        CHECK(level_db(*steady) > -60);
    }
    CHECK(eventually([&] { return thread_count() == before; }));
}
