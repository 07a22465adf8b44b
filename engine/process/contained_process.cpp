#include "process/contained_process.h"

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
#include <csignal>
#include <string>
#include <system_error>
#include <utility>

#include "aula/exception.h"

namespace aula {

namespace {

/// Limit of the waiting time for the child, which has 5 s of CPU time: it takes longer on a busy
/// machine or with a slow disk.
constexpr std::chrono::seconds kLongest{60};

[[noreturn]] void fail_to_start(const std::filesystem::path& file, int error) {
    throw Failure(file.string() + ": the process that reads SOFA files cannot be started, " +
                  std::generic_category().message(error) +
                  "; expected /proc, memory that may be executed, and limits that allow it");
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

/// Starts the program that reads `input` and writes to `output`. Returns 0, or an error.
int start(const Descriptor& program, const Descriptor& input, const Descriptor& output, pid_t& id) {
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
    const int error = posix_spawn(&id, path.c_str(), &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

}  // namespace

Descriptor::Descriptor(int number) : number_(number) {
    if (number_ < 0 || number_ > STDERR_FILENO) return;
    number_ = fcntl(number, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    close(number);
}

void Descriptor::reset() {
    if (number_ >= 0) close(std::exchange(number_, -1));
}

ContainedProcess::ContainedProcess(std::span<const std::byte> program,
                                   const std::filesystem::path& file, const char* expected)
    : deadline_(Clock::now() + kLongest) {
    const auto fail = [&](const std::string& why) {
        throw InputError(file.string() + ": " + why + "; expected " + expected);
    };
    // Non-blocking: opening a pipe does not wait for its other end.
    const Descriptor input(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (input.number() < 0 && errno == ENOENT) fail("no such file");
    if (input.number() < 0) fail("cannot be opened, " + std::generic_category().message(errno));
    struct stat status {};
    if (fstat(input.number(), &status) != 0 || !S_ISREG(status.st_mode))
        fail("is not a regular file");

    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) fail_to_start(file, errno);
    output_.emplace(ends[0]);
    const Descriptor to(ends[1]);
    const Descriptor executable(make_program_file());
    if (!write_all(executable, program)) fail_to_start(file, errno);
    if (const int error = start(executable, input, to, id_)) fail_to_start(file, error);
}

ContainedProcess::~ContainedProcess() {
    kill(id_, SIGKILL);
    // If the host ignores SIGCHLD or waits for any child, waitpid() fails.
    while (waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
}

bool ContainedProcess::read_bytes(void* bytes, std::size_t size) {
    auto* to = static_cast<std::byte*>(bytes);
    while (size > 0) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now());
        pollfd ready{output_->number(), POLLIN, 0};
        const int count = poll(&ready, 1, static_cast<int>(std::max<long>(left.count(), 0)));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return false;
        const ssize_t got = ::read(output_->number(), to, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        to += got;
        size -= static_cast<std::size_t>(got);
    }
    return true;
}

}  // namespace aula
