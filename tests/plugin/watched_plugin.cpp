// The built binary behind a binary of the tests that a host loads in its place. Each call of run()
// is timed by the processor time of its thread, which does not depend on other programs, and its
// input is a tone without gaps, also where the host omits blocks. The folder AULA_TEST_TAKE gets
// the file "active" with the number of the process when an instance is active, and at its end
// "sound", the first two outputs interleaved, and "calls", a WatchedCalls.

#include <dlfcn.h>
#include <lv2/core/lv2.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <vector>

#include "apps/plugin/lv2/ports.h"
#include "tests/plugin/watched_calls.h"

namespace {

using namespace aula;
using namespace aula::test;

constexpr std::size_t kLongestTake = std::size_t{150} * 48000;

/// Hosts of the tests have one instance.
struct Watched {
    const LV2_Descriptor* plugin = nullptr;
    LV2_Descriptor descriptor{};
    std::array<const float*, 3> outputs{};  ///< [port]
    const float* source_x = nullptr;
    float last_source_x = 0;
    std::vector<float> tone;
    std::vector<float> sound;
    std::size_t samples = 0;
    WatchedCalls calls;
};
Watched watched;

std::filesystem::path take_file(const char* name) {
    return std::filesystem::path(std::getenv("AULA_TEST_TAKE")) / name;
}

double thread_seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

rusage thread_usage() {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return usage;
}

void connect_port(LV2_Handle handle, std::uint32_t port, void* data) {
    if (port == plugin::kInputPort) return;
    if (port < watched.outputs.size()) watched.outputs[port] = static_cast<const float*>(data);
    if (port == plugin::control_port(OutputFormat::binaural, 0))
        watched.source_x = static_cast<const float*>(data);
    watched.plugin->connect_port(handle, port, data);
}

void activate(LV2_Handle handle) {
    watched.tone.resize(8192);
    watched.sound.resize(2 * kLongestTake);
    watched.plugin->activate(handle);
    watched.calls = {};
    std::ofstream(take_file("active")) << getpid();
}

void run(LV2_Handle handle, std::uint32_t samples) {
    for (std::uint32_t n = 0; n < samples; ++n) {
        const double time_s = static_cast<double>(watched.samples + n) / 48000;
        watched.tone[n] = kTone_amplitude *
                          static_cast<float>(std::min(1.0, time_s) *
                                             std::sin(2 * std::numbers::pi * kTone_hz * time_s));
    }
    watched.plugin->connect_port(handle, plugin::kInputPort, watched.tone.data());
    WatchedCalls& calls = watched.calls;
    const rusage before = thread_usage();
    const double begin_s = thread_seconds();
    watched.plugin->run(handle, samples);
    const double took_s = thread_seconds() - begin_s;
    const rusage after = thread_usage();
    const long faults = after.ru_minflt + after.ru_majflt - before.ru_minflt - before.ru_majflt;
    if (faults == 0) calls.waits += after.ru_nvcsw - before.ru_nvcsw;
    calls.page_faults += faults;
    ++calls.count;
    calls.total_s += took_s;
    calls.longest_s = std::max(calls.longest_s, took_s);
    if (took_s * 48000 > static_cast<double>(samples)) ++calls.late;
    if (*watched.source_x != watched.last_source_x) ++calls.moves;
    watched.last_source_x = *watched.source_x;
    const std::size_t kept =
        std::min<std::size_t>(samples, kLongestTake - std::min(kLongestTake, watched.samples));
    for (std::size_t n = 0; n < kept; ++n)
        for (std::size_t c = 0; c < 2; ++c)
            watched.sound[2 * (watched.samples + n) + c] = watched.outputs[1 + c][n];
    watched.samples += samples;
}

void cleanup(LV2_Handle handle) {
    watched.plugin->cleanup(handle);
    const std::size_t values = 2 * std::min(watched.samples, kLongestTake);
    std::ofstream(take_file("sound"), std::ios::binary)
        .write(reinterpret_cast<const char*>(watched.sound.data()),
               static_cast<std::streamsize>(values * sizeof(float)));
    std::ofstream(take_file("calls"), std::ios::binary)
        .write(reinterpret_cast<const char*>(&watched.calls), sizeof watched.calls);
}

}  // namespace

LV2_SYMBOL_EXPORT const LV2_Descriptor* lv2_descriptor(std::uint32_t index) {
    if (index != 0) return nullptr;  // binaural
    void* const library = dlopen(AULA_PLUGIN_BINARY, RTLD_NOW);
    if (library == nullptr) return nullptr;
    const auto get = reinterpret_cast<LV2_Descriptor_Function>(dlsym(library, "lv2_descriptor"));
    if (get == nullptr) return nullptr;
    watched.plugin = get(0);
    watched.descriptor = *watched.plugin;
    watched.descriptor.connect_port = connect_port;
    watched.descriptor.activate = activate;
    watched.descriptor.run = run;
    watched.descriptor.cleanup = cleanup;
    return &watched.descriptor;
}
