#include "audio/spatial/sofa_file.h"

#include <dirent.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "audio/spatial/hrtf.h"
#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

namespace sofa_file_test {

using namespace aula;

namespace {

constexpr double kRate_hz = 48000;
constexpr const char* kDefaultFile = "/usr/share/libmysofa/default.sofa";
const std::string kCorpus = AULA_SOURCE_DIR "/tests/fuzz/corpus/sofa/";
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Six directions along the axes; each response is an impulse with an echo.
HeadMeasurements measured() {
    HeadMeasurements m;
    m.file = "set.sofa";
    m.samples = 32;
    m.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    m.responses.resize(2 * m.positions.size() * m.samples);
    for (std::size_t r = 0; r < 2 * m.positions.size(); ++r) {
        m.responses[r * m.samples + 4] = 1;
        m.responses[r * m.samples + 6] = 0.5F;
    }
    m.delays_samples.resize(2 * m.positions.size());
    return m;
}

std::string error_of(const std::function<void()>& act) {
    try {
        act();
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

std::string error_of_file(const std::filesystem::path& file) {
    return error_of([&] { Hrtf(file, kRate_hz); });
}

std::size_t open_descriptors() {
    DIR* const folder = opendir("/proc/self/fd");
    std::size_t count = 0;
    while (readdir(folder) != nullptr) ++count;
    closedir(folder);
    return count;
}

int children_ended = 0;
void count_child(int) { ++children_ended; }

}  // namespace

TEST_CASE("Measurements are read from a SOFA file unchanged") {
    const HeadMeasurements m = read_sofa(kCorpus + "plain.sofa");
    CHECK(m.sample_rate_hz == 48000);
    CHECK(m.samples == 8);
    REQUIRE(m.positions.size() == 6);
    // Azimuth 90 degrees at 1.4 m is on the left; rounding of single precision.
    CHECK(m.positions[1][0] == Approx(0).margin(1e-6));
    CHECK(m.positions[1][1] == Approx(1.4));
    REQUIRE(m.responses.size() == 96);
    for (std::size_t r = 0; r < 12; ++r) {
        const std::vector<float> response(
            m.responses.begin() + static_cast<std::ptrdiff_t>(8 * r),
            m.responses.begin() + static_cast<std::ptrdiff_t>(8 * r) + 8);
        CHECK(response == std::vector<float>{0, 0, 1, 0.3F, 0, 0, 0, 0});
    }
    CHECK(m.delays_samples == std::vector<float>(12));
}

TEST_CASE("The delays of the ears that a SOFA file gives once hold for all directions") {
    // As plain.sofa, with delays of 3 and 5 samples.
    const HeadMeasurements m = read_sofa(kCorpus + "delays.sofa");
    CHECK(m.delays_samples == std::vector<float>{3, 5, 3, 5, 3, 5, 3, 5, 3, 5, 3, 5});
}

TEST_CASE("Implausible measurements are refused in one line") {
    CHECK(error_of([] { Hrtf(measured(), kRate_hz); }).empty());
    const std::vector<std::pair<const char*, std::function<void(HeadMeasurements&)>>> faults{
        {"a response with NaN", [](auto& m) { m.responses[70] = kNan; }},
        {"a response with infinity", [](auto& m) { m.responses[70] = -kInfinity; }},
        {"a silent response", [](auto& m) { std::fill_n(m.responses.begin() + 32, 32, 0.0F); }},
        {"all silent", [](auto& m) { std::fill(m.responses.begin(), m.responses.end(), 0.0F); }},
        {"a response too loud", [](auto& m) { m.responses[70] = 1e30F; }},
        {"no rate", [](auto& m) { m.sample_rate_hz = 0; }},
        {"a rate of 1 Hz", [](auto& m) { m.sample_rate_hz = 1; }},
        {"a negative rate", [](auto& m) { m.sample_rate_hz = -48000; }},
        {"a rate of NaN", [](auto& m) { m.sample_rate_hz = kNan; }},
        {"an infinite rate", [](auto& m) { m.sample_rate_hz = kInfinity; }},
        {"a source in the head",
         [](auto& m) {
             m.positions[2] = {0, 0, 0};
         }},
        {"a source at NaN",
         [](auto& m) {
             m.positions[2] = {0, kNan, 0};
         }},
        {"a source at infinity",
         [](auto& m) {
             m.positions[2] = {0, kInfinity, 0};
         }},
        {"a source too far",
         [](auto& m) {
             m.positions[2] = {1e30F, 0, 0};
         }},
        {"a delay of NaN", [](auto& m) { m.delays_samples[3] = kNan; }},
        {"a delay of an hour", [](auto& m) { m.delays_samples[3] = 1e9F; }},
        {"all delays minus an hour",
         [](auto& m) { m.delays_samples.assign(m.delays_samples.size(), -1e9F); }},
        {"a delay of half a second", [](auto& m) { m.delays_samples[3] = 24000; }},
        {"fewer responses", [](auto& m) { m.responses.resize(32); }},
        {"fewer delays", [](auto& m) { m.delays_samples.resize(2); }},
        {"three directions", [](auto& m) {
             m.positions.resize(3);
             m.responses.resize(6 * m.samples);
             m.delays_samples.resize(6);
         }}};
    for (const auto& [name, fault] : faults) {
        HeadMeasurements m = measured();
        fault(m);
        const std::string error = error_of([&, &faulty = m] { Hrtf(faulty, kRate_hz); });
        CAPTURE(name, error);
        CHECK(error.starts_with("set.sofa: "));
        CHECK(error.find("; expected ") != std::string::npos);
        CHECK(error.find('\n') == std::string::npos);
    }
}

TEST_CASE("Measurements at 8 to 768 kHz are accepted") {
    for (const auto& [rate_hz, accepted] : {std::pair(8000.0F, true),
                                            {std::nextafter(8000.0F, 0.0F), false},
                                            {768e3F, true},
                                            {std::nextafter(768e3F, 1e6F), false}}) {
        HeadMeasurements m = measured();
        m.sample_rate_hz = rate_hz;
        const std::string error = error_of([&] { Hrtf(m, kRate_hz); });
        CAPTURE(rate_hz, error);
        CHECK(error.empty() == accepted);
        if (!accepted) CHECK(error.find("expected 8000 to 768000 Hz") != std::string::npos);
    }
}

TEST_CASE("A SOFA file with fewer responses than its sizes say is refused") {
    const std::string error = error_of_file(kCorpus + "short_ir.sofa");
    CHECK(error.find("short_ir.sofa: has fewer values than its sizes say; ") != std::string::npos);
    CHECK(error_of_file(kCorpus + "nan.sofa").find("is not finite") != std::string::npos);
    CHECK(error_of_file(kCorpus + "rate_1hz.sofa").find("a sample rate of") != std::string::npos);
}

TEST_CASE("A SOFA file that h5py wrote is refused with the program that converts it") {
    for (const char* file : {"h5py.sofa", "h5py_latest.sofa"}) {
        const std::string error = error_of_file(kCorpus + file);
        CAPTURE(error);
        CHECK(error.find("is HDF5 but not netCDF-4, as h5py writes it") != std::string::npos);
        CHECK(error.find("sofar.write_sofa(") != std::string::npos);
        CHECK(error.find('\n') == std::string::npos);
    }
    // Companion: a damaged file of netCDF.
    CHECK(error_of_file(kCorpus + "endless.sofa").find("h5py") == std::string::npos);
}

TEST_CASE("A SOFA file has responses of at most 32768 samples") {
    CHECK(read_sofa(kCorpus + "longest.sofa").samples == 32768);
    const std::string error = error_of_file(kCorpus + "too_long.sofa");  // one sample more
    CHECK(error.find("responses of more than 32768") != std::string::npos);
}

TEST_CASE("A SOFA file for which the parser does not terminate is refused") {
    CHECK(error_of_file(kCorpus + "endless.sofa").find("is damaged") != std::string::npos);
}

TEST_CASE("A SOFA file that is not a regular file is refused without waiting") {
    const test::TemporaryFolder folder;
    const std::filesystem::path pipe = folder.path() / "pipe.sofa";
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    for (const std::filesystem::path& file :
         {pipe, folder.path(), std::filesystem::path("/dev/zero"), folder.path() / "missing"}) {
        const std::string error = error_of_file(file);
        CAPTURE(file, error);
        CHECK(error.starts_with(file.string() + ": "));
        CHECK(error.find("expected a SOFA file") != std::string::npos);
    }
}

TEST_CASE("Reading a SOFA file leaves no process and no descriptor behind") {
    const std::size_t before = open_descriptors();
    for (const std::string& file : {std::string(kDefaultFile), kCorpus + "short_ir.sofa"})
        error_of_file(file);
    CHECK(open_descriptors() == before);
    CHECK(waitpid(-1, nullptr, WNOHANG) == -1);
    CHECK(errno == ECHILD);
}

TEST_CASE("Reading a SOFA file preserves the host's handling of signals") {
    struct sigaction ours {};
    ours.sa_handler = count_child;
    struct sigaction host {};
    REQUIRE(sigaction(SIGCHLD, &ours, &host) == 0);
    children_ended = 0;
    CHECK(error_of_file(kDefaultFile).empty());
    struct sigaction after {};
    REQUIRE(sigaction(SIGCHLD, &host, &after) == 0);
    CHECK(after.sa_handler == count_child);
    // If the host ignores SIGCHLD, the kernel reaps its children.
    const auto handler = std::signal(SIGCHLD, SIG_IGN);
    CHECK(error_of_file(kDefaultFile).empty());
    CHECK(error_of_file(kCorpus + "short_ir.sofa").find("fewer values") != std::string::npos);
    std::signal(SIGCHLD, handler);
    // The child does not inherit blocked signals; otherwise it could not be terminated.
    sigset_t all;
    sigset_t mask;
    sigfillset(&all);
    REQUIRE(pthread_sigmask(SIG_BLOCK, &all, &mask) == 0);
    CHECK(error_of_file(kDefaultFile).empty());
    pthread_sigmask(SIG_SETMASK, &mask, nullptr);
}

TEST_CASE("A SOFA file is read if standard input and output are closed") {
    const int input = dup(STDIN_FILENO);
    const int output = dup(STDOUT_FILENO);
    std::fflush(stdout);
    close(STDIN_FILENO);
    close(STDOUT_FILENO);
    const std::string error = error_of_file(kDefaultFile);
    if (input >= 0) dup2(input, STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    close(input);
    close(output);
    CHECK(error.empty());
}

}  // namespace sofa_file_test
