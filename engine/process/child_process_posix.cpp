#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__APPLE__)
#include <libproc.h>
#include <mach/mach_time.h>
#include <sys/stat.h>
#else
#include <dlfcn.h>
#include <link.h>
#include <sched.h>
#include <sys/mman.h>
#endif

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "process/child_process.h"
#include "process/contained_program.h"
#include "process/files.h"

namespace aula {

namespace {

constexpr const char* kName = "aula-reader";  // of the process, for ps

[[noreturn]] void fail_start(int error) { throw std::system_error(error, std::generic_category()); }

std::string_view bytes_of(std::span<const std::byte> program) {
    return {reinterpret_cast<const char*>(program.data()), program.size()};
}

#if defined(__APPLE__)

/// An executable temporary file, which is removed with this object.
class TemporaryProgram {
 public:
    explicit TemporaryProgram(std::span<const std::byte> program)
        : path_((std::filesystem::temp_directory_path() / "aula-XXXXXX").string()),
          opened_(mkostemp(path_.data(), O_CLOEXEC)) {
        if (opened_.number() < 0) fail_start(errno);
        try {
            write_all(opened_.number(), bytes_of(program));
            if (fchmod(opened_.number(), S_IRWXU) != 0) fail_start(errno);
            opened_.reset();  // a file that is open for writing cannot be executed
        } catch (...) {
            unlink(path_.c_str());
            throw;
        }
    }
    ~TemporaryProgram() { unlink(path_.c_str()); }
    TemporaryProgram(const TemporaryProgram&) = delete;
    TemporaryProgram& operator=(const TemporaryProgram&) = delete;

    const std::string& path() const { return path_; }

 private:
    std::string path_;
    Descriptor opened_;
};

/// A program as a file: the given one, or one that is written here.
class ProgramFile {
 public:
    explicit ProgramFile(const ContainedProgram& program) {
        if (const auto* const file = std::get_if<std::filesystem::path>(&program))
            path_ = file->string();
        else
            path_ = temporary_.emplace(std::get<0>(program)).path();
    }

    const std::string& path() const { return path_; }

 private:
    std::optional<TemporaryProgram> temporary_;
    std::string path_;
};

constexpr const char* kLibraryFolders = "DYLD_LIBRARY_PATH";

/// The names of libraries that a binary needs are absolute on macOS, or in the run path of the
/// program; @loader_path, the folder of the temporary file, is not supported.
std::string run_path() { return ""; }

/// A new process has no real-time priority. It inherits only what adddup2() gives it.
short spawn_flags(posix_spawnattr_t&) { return POSIX_SPAWN_CLOEXEC_DEFAULT; }

int make_pipe(int (&ends)[2]) {
    if (pipe(ends) != 0) return -1;
    for (const int end : ends) fcntl(end, F_SETFD, FD_CLOEXEC);
    return 0;
}

/// Processor time of a process, or 0.
std::chrono::nanoseconds processor_time_of(int id) {
    rusage_info_v0 used{};
    mach_timebase_info_data_t unit{};
    if (proc_pid_rusage(id, RUSAGE_INFO_V0, reinterpret_cast<rusage_info_t*>(&used)) != 0 ||
        mach_timebase_info(&unit) != 0)
        return {};
    const std::uint64_t ticks = used.ri_user_time + used.ri_system_time;
    return std::chrono::nanoseconds(ticks * unit.numer / unit.denom);
}

#else

/// Creates an executable file in memory.
int make_program_file() {
#ifndef MFD_EXEC
    constexpr unsigned MFD_EXEC = 0x10;  // since Linux 6.3, where execution may require it
#endif
    const int made = memfd_create(kName, MFD_CLOEXEC | MFD_EXEC);
    if (made >= 0 || errno != EINVAL) return made;
    return memfd_create(kName, MFD_CLOEXEC);
}

/// The opened program, whose bytes are written to an executable file in memory.
class ProgramFile {
 public:
    explicit ProgramFile(const ContainedProgram& program) : opened_(open_program(program)) {
        if (const auto* const bytes = std::get_if<std::span<const std::byte> >(&program))
            write_all(opened_.number(), bytes_of(*bytes));
    }

    std::string path() const { return "/proc/self/fd/" + std::to_string(opened_.number()); }

 private:
    static int open_program(const ContainedProgram& program) {
        const auto* const file = std::get_if<std::filesystem::path>(&program);
        const int number =
            file != nullptr ? open(file->c_str(), O_RDONLY | O_CLOEXEC) : make_program_file();
        if (number < 0) fail_start(errno);
        return number;
    }

    Descriptor opened_;
};

constexpr const char* kLibraryFolders = "LD_LIBRARY_PATH";

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

/// Takes the new process out of a real-time policy. Returns flags for posix_spawnattr_setflags().
short spawn_flags(posix_spawnattr_t& attributes) {
    // Only from a real-time policy: a process of the policy idle may not leave it.
    if (!has_real_time_policy()) return 0;
    const sched_param ordinary{};
    posix_spawnattr_setschedpolicy(&attributes, SCHED_OTHER);
    posix_spawnattr_setschedparam(&attributes, &ordinary);
    return POSIX_SPAWN_SETSCHEDULER;
}

int make_pipe(int (&ends)[2]) { return pipe2(ends, O_CLOEXEC); }

/// Processor time of a process, or 0: one that another thread of the host has waited for has no
/// clock.
std::chrono::nanoseconds processor_time_of(int id) {
    clockid_t clock{};
    timespec time{};
    if (clock_getcpuclockid(id, &clock) != 0 || clock_gettime(clock, &time) != 0) return {};
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

#endif

/// Where the program finds its libraries, as kLibraryFolders: in the folders in which the binary
/// that contains this code finds its own. The program itself, in memory, has no $ORIGIN.
std::string library_folders() {
    const char* const inherited = std::getenv(kLibraryFolders);
    std::string folders = inherited != nullptr ? inherited : "";
    const std::string own = run_path();
    if (!folders.empty() && !own.empty()) folders += ':';
    return folders + own;
}

/// Starts the program that reads `input` and writes to `output`. Returns 0, or an error.
int start(const std::string& program, const Descriptor& input, const Descriptor& output,
          pid_t& id) {
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
    const short system = spawn_flags(attributes);
    posix_spawnattr_setflags(
        &attributes, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | system));
    std::string name = kName;
    char* const arguments[] = {name.data(), nullptr};
    // Of the environment only what finds the libraries: preloaded libraries and settings of
    // malloc() and HDF5 may need system calls that are forbidden to the process.
    const std::string folders = library_folders();
    std::string libraries = kLibraryFolders + ("=" + folders);
    char* const environment[] = {folders.empty() ? nullptr : libraries.data(), nullptr};
    const int error =
        posix_spawn(&id, program.c_str(), &files, &attributes, arguments, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

}  // namespace

const char* const ChildProcess::kNeeds =
#if defined(__APPLE__)
    "a folder for temporary files, and limits that allow it";
#else
    "/proc, memory that may be executed, and limits that allow it";
#endif

struct ChildProcess::State {
    std::optional<Descriptor> output;
    int id = -1;  ///< -1 if the process has been waited for

    /// Kills the process and waits for it. Returns its status, as waitpid() does, or 0.
    int end() {
        int status = 0;
        if (id < 0) return status;
        // If the host ignores SIGCHLD or waits for any child, waitpid() fails.
        kill(id, SIGKILL);
        while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
        }
        id = -1;
        return status;
    }
};

ChildProcess::ChildProcess(const ContainedProgram& program, const Descriptor& input)
    : state_(std::make_unique<State>()) {
    int ends[2] = {-1, -1};
    if (make_pipe(ends) != 0) fail_start(errno);
    state_->output.emplace(ends[0]);
    const Descriptor to(ends[1]);
    const ProgramFile executable(program);
    if (const int error = start(executable.path(), input, to, state_->id)) fail_start(error);
}

ChildProcess::~ChildProcess() { state_->end(); }

bool ChildProcess::wait(std::chrono::nanoseconds timeout) {
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(timeout);
    pollfd ready{state_->output->number(), POLLIN, 0};
    return poll(&ready, 1, static_cast<int>(milliseconds.count())) > 0;
}

std::size_t ChildProcess::read(void* bytes, std::size_t size) {
    ssize_t got = -1;
    do {
        got = ::read(state_->output->number(), bytes, size);
    } while (got < 0 && errno == EINTR);
    return got > 0 ? static_cast<std::size_t>(got) : 0;
}

std::chrono::nanoseconds ChildProcess::processor_time() const {
    return processor_time_of(state_->id);
}

ChildProcess::End ChildProcess::end() {
    const int status = state_->end();
    if (WIFEXITED(status) && WEXITSTATUS(status) == kNotMapped) return End::not_mapped;
    if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory) return End::out_of_memory;
    if (!WIFSIGNALED(status)) return End::early;
    switch (WTERMSIG(status)) {
        case SIGSYS:
            return End::forbidden_call;
        case SIGXCPU:
            return End::out_of_time;
        default:
            return End::crashed;
    }
}

}  // namespace aula
