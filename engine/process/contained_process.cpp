#include "process/contained_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/contained_program.h"
#include "process/regular_file.h"

namespace aula {

namespace {

/// Limits of the processor time and of the time between two parts of the answer. The former allows
/// the largest valid file on a slow machine, the latter a busy machine or a slow disk.
constexpr std::chrono::seconds kLongestComputation{5};
constexpr std::chrono::seconds kLongest{60};

constexpr const char* kName = "aula-reader";  // of the process, for ps

[[noreturn]] void fail_to_start(const std::filesystem::path& file, int error) {
    throw Failure(file.string() + ": the process that reads it cannot be started, " +
                  std::generic_category().message(error) +
                  "; expected /proc, memory that may be executed, and limits that allow it");
}

/// Creates an executable file in memory.
int make_program_file() {
#ifndef MFD_EXEC
    constexpr unsigned MFD_EXEC = 0x10;  // since Linux 6.3, where execution may require it
#endif
    const int made = memfd_create(kName, MFD_CLOEXEC | MFD_EXEC);
    if (made >= 0 || errno != EINVAL) return made;
    return memfd_create(kName, MFD_CLOEXEC);
}

bool write_all(const Descriptor& to, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(to.number(), bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return true;
}

/// Opens the program, whose bytes are written to an executable file in memory. Returns nothing if
/// an error, in errno, prevents it.
std::optional<Descriptor> open_program(const ContainedProgram& program) {
    const auto* const file = std::get_if<std::filesystem::path>(&program);
    const int number =
        file != nullptr ? open(file->c_str(), O_RDONLY | O_CLOEXEC) : make_program_file();
    if (number < 0) return std::nullopt;
    std::optional<Descriptor> opened(std::in_place, number);
    if (file == nullptr && !write_all(*opened, std::get<0>(program))) return std::nullopt;
    return opened;
}

bool has_real_time_policy() {
#ifndef SCHED_DEADLINE
    constexpr int SCHED_DEADLINE = 6;
#endif
    const int policy = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
    return policy == SCHED_FIFO || policy == SCHED_RR || policy == SCHED_DEADLINE;
}

/// RUNPATH of the binary that contains this code, with its folder in place of $ORIGIN; or empty.
std::string run_path() {
    Dl_info place{};
    link_map* binary = nullptr;
    if (dladdr1(reinterpret_cast<void*>(&run_path), &place, reinterpret_cast<void**>(&binary),
                RTLD_DL_LINKMAP) == 0)
        return "";
    const char* strings = nullptr;
    const ElfW(Dyn)* run_path = nullptr;
    for (const ElfW(Dyn)* entry = binary->l_ld; entry->d_tag != DT_NULL; ++entry) {
        if (entry->d_tag == DT_STRTAB) strings = reinterpret_cast<const char*>(entry->d_un.d_ptr);
        if (entry->d_tag == DT_RUNPATH) run_path = entry;
    }
    if (strings == nullptr || run_path == nullptr) return "";
    std::string folders = strings + run_path->d_un.d_val;
    // The program of the process has no name here.
    std::error_code error;
    const std::filesystem::path file = binary->l_name[0] != '\0'
                                           ? std::filesystem::path(binary->l_name)
                                           : std::filesystem::read_symlink("/proc/self/exe", error);
    const std::string folder = file.parent_path().string();
    constexpr std::string_view kOrigin = "$ORIGIN";
    for (auto at = folders.find(kOrigin); at != std::string::npos;
         at = folders.find(kOrigin, at + folder.size()))
        folders.replace(at, kOrigin.size(), folder);
    return folders;
}

/// Where the program finds its libraries, as LD_LIBRARY_PATH: in the folders in which the binary
/// that contains this code finds its own. The program itself, in memory, has no $ORIGIN.
std::string library_folders() {
    const char* const inherited = std::getenv("LD_LIBRARY_PATH");
    std::string folders = inherited != nullptr ? inherited : "";
    const std::string own = run_path();
    if (!folders.empty() && !own.empty()) folders += ':';
    return folders + own;
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
    short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
    // Only from a real-time policy: a process of the policy idle may not leave it.
    if (has_real_time_policy()) {
        const sched_param ordinary{};
        posix_spawnattr_setschedpolicy(&attributes, SCHED_OTHER);
        posix_spawnattr_setschedparam(&attributes, &ordinary);
        flags |= POSIX_SPAWN_SETSCHEDULER;
    }
    posix_spawnattr_setflags(&attributes, flags);
    const std::string path = "/proc/self/fd/" + std::to_string(program.number());
    std::string name = kName;
    char* const arguments[] = {name.data(), nullptr};
    // Of the environment only what finds the libraries: preloaded libraries and settings of
    // malloc() and HDF5 may need system calls that are forbidden to the process.
    const std::string folders = library_folders();
    std::string libraries = "LD_LIBRARY_PATH=" + folders;
    char* const environment[] = {folders.empty() ? nullptr : libraries.data(), nullptr};
    const int error = posix_spawn(&id, path.c_str(), &files, &attributes, arguments, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

/// How the process ended, as waitpid() says.
const char* how_it_ended(int status) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory)
        return "needs more than 1 GiB of memory";
    if (!WIFSIGNALED(status)) return "ends before its answer is complete";
    switch (WTERMSIG(status)) {
        case SIGSYS:
            return "makes a system call that is forbidden to it";
        case SIGXCPU:
            return "needs more processor time than it may take";
        default:
            return "crashes";
    }
}

}  // namespace

ContainedProcess::ContainedProcess(const ContainedProgram& program, std::filesystem::path file,
                                   std::string expected)
    : file_(std::move(file)), expected_(std::move(expected)) {
    begin(program, RegularFile(file_, expected_.c_str()).descriptor());
}

ContainedProcess::ContainedProcess(const ContainedProgram& program, std::string_view bytes,
                                   std::filesystem::path name, std::string expected)
    : file_(std::move(name)), expected_(std::move(expected)) {
    const int made = memfd_create(kName, MFD_CLOEXEC);
    if (made < 0) fail_to_start(file_, errno);
    const Descriptor input(made);
    if (!write_all(input, std::as_bytes(std::span(bytes)))) fail_to_start(file_, errno);
    begin(program, input);
}

/// Starts the process.
void ContainedProcess::begin(const ContainedProgram& program, const Descriptor& input) {
    int ends[2] = {-1, -1};
    if (pipe2(ends, O_CLOEXEC) != 0) fail_to_start(file_, errno);
    output_.emplace(ends[0]);
    const Descriptor to(ends[1]);
    const std::optional<Descriptor> executable = open_program(program);
    if (!executable) fail_to_start(file_, errno);
    if (const int error = start(*executable, input, to, id_)) fail_to_start(file_, error);
    answered_ = Clock::now();
}

ContainedProcess::~ContainedProcess() { end(); }

int ContainedProcess::end() {
    int status = 0;
    if (id_ < 0) return status;
    // If the host ignores SIGCHLD or waits for any child, waitpid() fails.
    kill(id_, SIGKILL);
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
}

void ContainedProcess::refuse_as_ended(int status) const {
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotMapped)
        refuse("cannot be mapped into memory");
    refuse_as_damaged(how_it_ended(status));
}

void ContainedProcess::refuse_as_damaged(const std::string& how) const {
    refuse("is damaged and cannot be read: the process that reads it " + how);
}

void ContainedProcess::refuse(const std::string& problem) const {
    throw InputError(file_.string() + ": " + problem + "; expected " + expected_);
}

std::chrono::nanoseconds ContainedProcess::processor_time() const {
    clockid_t clock{};
    timespec time{};
    // A process that another thread of the host has waited for has no clock.
    if (clock_getcpuclockid(id_, &clock) != 0 || clock_gettime(clock, &time) != 0) return {};
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void ContainedProcess::wait_for_answer() {
    std::chrono::nanoseconds left{0};
    while (true) {
        const auto timeout = std::chrono::ceil<std::chrono::milliseconds>(left);
        pollfd ready{output_->number(), POLLIN, 0};
        if (poll(&ready, 1, static_cast<int>(timeout.count())) > 0) return;
        const auto waited = Clock::now() - answered_;
        const auto computed = processor_time() - computed_;
        if (computed >= kLongestComputation)
            refuse_as_damaged("computes for 5 s without an answer");
        if (waited >= kLongest) refuse_as_damaged("gives no answer for 60 s");
        // The process has one thread: its processor time passes no faster than time.
        left =
            std::min<std::chrono::nanoseconds>(kLongestComputation - computed, kLongest - waited);
    }
}

void ContainedProcess::read_bytes(void* bytes, std::size_t size) {
    auto* to = static_cast<std::byte*>(bytes);
    while (size > 0) {
        wait_for_answer();
        const ssize_t got = ::read(output_->number(), to, size);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) refuse_as_ended(end());
        to += got;
        size -= static_cast<std::size_t>(got);
    }
    answered_ = Clock::now();
    computed_ = processor_time();
}

}  // namespace aula
