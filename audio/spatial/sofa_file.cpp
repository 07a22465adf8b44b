#include "audio/spatial/sofa_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "audio/spatial/embedded_sofa_reader.h"
#include "audio/spatial/sofa_stream.h"
#include "aula/exception.h"

namespace aula {

namespace {

using Clock = std::chrono::steady_clock;

/// Limit of the waiting time for the child, which has 5 s of CPU time: it takes longer on a busy
/// machine or with a slow disk.
constexpr std::chrono::seconds kLongest{60};

class Descriptor {
 public:
    /// Takes ownership of a descriptor. Moves it above the standard descriptors, which the child
    /// replaces.
    explicit Descriptor(int number) : number_(number) {
        if (number_ < 0 || number_ > STDERR_FILENO) return;
        number_ = fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
        close(number);
    }
    ~Descriptor() { reset(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    void reset() {
        if (number_ >= 0) close(std::exchange(number_, -1));
    }
    int number() const { return number_; }

 private:
    int number_;
};

[[noreturn]] void fail_to_start(const std::filesystem::path& file) {
    throw Failure(file.string() +
                  ": the process that reads SOFA files cannot be started; expected /proc and "
                  "memory that may be executed");
}

/// Creates an executable file in memory.
int make_program_file() {
#ifndef MFD_EXEC
    constexpr unsigned MFD_EXEC = 0x10;  // since Linux 6.3, where execution may require it
#endif
    const int made = memfd_create("aula-sofa-reader", MFD_CLOEXEC | MFD_EXEC);
    if (made >= 0 || errno != EINVAL) return made;
    return memfd_create("aula-sofa-reader", MFD_CLOEXEC);
}

bool write_all(const Descriptor& to, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = write(to.number(), bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return true;
}

/// A child process that reads `input` and writes to `output`. The destructor kills it and waits for
/// it, by its process id only.
class Child {
 public:
    Child(const Descriptor& program, const Descriptor& input, const Descriptor& output) {
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_adddup2(&files, input.number(), STDIN_FILENO);
        posix_spawn_file_actions_adddup2(&files, output.number(), STDOUT_FILENO);
        posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
        // Default signal handling and no real-time priority, independent of the caller.
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        sigset_t signals;
        sigemptyset(&signals);
        posix_spawnattr_setsigmask(&attributes, &signals);
        sigfillset(&signals);
        posix_spawnattr_setsigdefault(&attributes, &signals);
        const sched_param ordinary{};
        posix_spawnattr_setschedpolicy(&attributes, SCHED_OTHER);
        posix_spawnattr_setschedparam(&attributes, &ordinary);
        posix_spawnattr_setflags(
            &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSCHEDULER);
        const std::string path = "/proc/self/fd/" + std::to_string(program.number());
        std::string name = "aula-sofa-reader";
        char* const arguments[] = {name.data(), nullptr};
        if (posix_spawn(&id_, path.c_str(), &files, &attributes, arguments, environ) != 0) id_ = -1;
        posix_spawnattr_destroy(&attributes);
        posix_spawn_file_actions_destroy(&files);
    }
    ~Child() {
        if (id_ < 0) return;
        kill(id_, SIGKILL);
        // If the host ignores SIGCHLD or waits for any child, waitpid() fails.
        while (waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    bool started() const { return id_ >= 0; }

 private:
    pid_t id_ = -1;
};

/// Reads exactly `size` bytes. Returns false if they are not available before the deadline.
bool read_all(const Descriptor& from, void* bytes, std::size_t size, Clock::time_point deadline) {
    auto* to = static_cast<std::byte*>(bytes);
    while (size > 0) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        pollfd ready{from.number(), POLLIN, 0};
        const int count = poll(&ready, 1, static_cast<int>(std::max<long>(left.count(), 0)));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        const ssize_t got = read(from.number(), to, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        to += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

template <typename T>
bool read_all(const Descriptor& from, std::vector<T>& values, Clock::time_point deadline) {
    return read_all(from, values.data(), values.size() * sizeof(T), deadline);
}

}  // namespace

HeadMeasurements read_sofa(const std::filesystem::path& file) {
    const auto fail = [&](const char* why) {
        throw InputError(file.string() + ": " + why +
                         "; expected a SOFA file of head-related impulse responses "
                         "(SimpleFreeFieldHRIR)");
    };
    // Non-blocking: opening a pipe does not wait for its other end.
    const Descriptor input(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (input.number() < 0) fail(errno == EACCES ? "may not be read" : "no such file");
    struct stat status {};
    if (fstat(input.number(), &status) != 0 || !S_ISREG(status.st_mode))
        fail("is not a regular file");

    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) fail_to_start(file);
    const Descriptor from(ends[0]);
    Descriptor to(ends[1]);
    const Descriptor program(make_program_file());
    if (!write_all(program, embedded_sofa_reader())) fail_to_start(file);
    const Child child(program, input, to);
    if (!child.started()) fail_to_start(file);
    to.reset();

    const Clock::time_point deadline = Clock::now() + kLongest;
    SofaHeader header;
    if (!read_all(from, &header, sizeof(header), deadline) || header.magic != SofaHeader::kMagic)
        fail("is damaged and cannot be read as SOFA");
    using Verdict = SofaHeader::Verdict;
    const std::size_t directions = header.directions;
    const std::size_t samples = header.samples;
    switch (header.verdict) {
        case Verdict::usable:
            break;
        case Verdict::other_kind:
            fail("has no two ears and four directions, or is a SOFA file of another kind");
            break;
        case Verdict::incomplete:
            fail("has fewer values than its sizes say");
            break;
        case Verdict::too_large:
            fail(
                "has more than 65536 directions, or responses of more than 32768 or, together, "
                "33554432 samples");
            break;
        default:
            fail("cannot be read as SOFA");
    }
    if (directions > kMaxDirections || samples > kLongestResponse_samples ||
        2 * directions * samples > kMaxResponseSamples)
        fail("is damaged and cannot be read as SOFA");
    HeadMeasurements measurements;
    measurements.file = file;
    measurements.sample_rate_hz = header.sample_rate_hz;
    measurements.samples = samples;
    measurements.positions.resize(directions);
    measurements.responses.resize(2 * directions * samples);
    measurements.delays_samples.resize(2 * directions);
    if (!read_all(from, measurements.positions, deadline) ||
        !read_all(from, measurements.responses, deadline) ||
        !read_all(from, measurements.delays_samples, deadline))
        fail("is damaged and cannot be read as SOFA");
    return measurements;
}

}  // namespace aula
