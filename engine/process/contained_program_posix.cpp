#include "process/contained_program.h"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#if defined(__APPLE__)
#include <mach/mach.h>
#include <sandbox.h>
#else
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/futex.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace aula {

#if defined(__APPLE__)

namespace {

/// XNU refuses limits below what is mapped, with gigabytes of shared libraries.
rlim_t memory_limit(std::size_t) {
    mach_task_basic_info task{};
    mach_msg_type_number_t size = MACH_TASK_BASIC_INFO_COUNT;
    task_info(mach_task_self(), MACH_TASK_BASIC_INFO, reinterpret_cast<task_info_t>(&task), &size);
    return task.virtual_size + kContainedMemory_bytes;
}

void end_with_parent() {}

}  // namespace

// POSIX_SPAWN_CLOEXEC_DEFAULT has left no others.
void close_descriptors() { close(STDIN_FILENO); }

void forbid_files() {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"  // without a successor
    char* error = nullptr;
    if (sandbox_init(kSBXProfilePureComputation, SANDBOX_NAMED, &error) != 0)
        sandbox_free_error(error);
#pragma GCC diagnostic pop
}

void filter_calls() {}

#else

namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kProcessor = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kProcessor = AUDIT_ARCH_AARCH64;
#elif defined(__riscv) && __riscv_xlen == 64
constexpr std::uint32_t kProcessor = AUDIT_ARCH_RISCV64;
#else
constexpr std::uint32_t kProcessor = 0;
#endif

/// Calls that are allowed with any argument. The libraries need:
constexpr long kFree[] = {
    // malloc() and free();
    SYS_brk, SYS_mremap, SYS_munmap,
    // the time, where the kernel provides none without a call;
    SYS_clock_gettime, SYS_gettimeofday,
    // qsort() of glibc before 2.37, for the size of the memory;
    SYS_sysinfo,
    // exit() and abort(), with tgkill().
    SYS_exit, SYS_exit_group, SYS_getpid, SYS_gettid, SYS_rt_sigprocmask};

/// A filter of system calls, in the kernel's language (linux/filter.h, linux/seccomp.h).
class CallFilter {
 public:
    CallFilter() {
        load(offsetof(seccomp_data, arch));
        // The x32 calls of x86-64 have the same processor, but other numbers than all calls below.
        add(BPF_JMP | BPF_JEQ | BPF_K, kProcessor, 1, 0);
        finish(SECCOMP_RET_KILL_PROCESS);
        load(offsetof(seccomp_data, nr));
    }

    /// What happens at a call.
    void on(long call, std::uint32_t action) {
        unless_equal(call, 1);
        finish(action);
    }
    /// Allows a call if the low 32 bits of its argument have one of two values.
    void allow_if_equal(long call, std::size_t argument, long one, long other) {
        unless_equal(call, 6);
        load_argument(argument);
        unless_equal(one, 1);
        finish(SECCOMP_RET_ALLOW);
        unless_equal(other, 1);
        finish(SECCOMP_RET_ALLOW);
        finish(SECCOMP_RET_KILL_PROCESS);
    }
    /// Allows a call if its argument has none of these bits.
    void allow_unless_set(long call, std::size_t argument, std::uint32_t bits) {
        unless_equal(call, 4);
        load_argument(argument);
        add(BPF_JMP | BPF_JSET | BPF_K, bits, 1);
        finish(SECCOMP_RET_ALLOW);
        finish(SECCOMP_RET_KILL_PROCESS);
    }
    /// Makes the filter hold for the process; any other call ends it.
    void install() {
        finish(SECCOMP_RET_KILL_PROCESS);
        const sock_fprog program{static_cast<unsigned short>(statements_.size()),
                                 statements_.data()};
        prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
    }

 private:
    void add(int code, std::uint32_t value, unsigned char skipped = 0,
             unsigned char skipped_else = 0) {
        statements_.push_back({static_cast<unsigned short>(code), skipped, skipped_else, value});
    }
    void load(std::size_t offset) {
        add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
    }
    void load_argument(std::size_t index) {  // the low half, on little-endian processors
        load(offsetof(seccomp_data, args) + index * sizeof(seccomp_data::args[0]));
    }
    /// Skips statements unless the loaded number has this value.
    void unless_equal(long value, unsigned char skipped) {
        add(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(value), 0, skipped);
    }
    void finish(std::uint32_t action) { add(BPF_RET | BPF_K, action); }

    std::vector<sock_filter> statements_;
};

rlim_t memory_limit(std::size_t mapped_bytes) { return mapped_bytes + kContainedMemory_bytes; }

void end_with_parent() { prctl(PR_SET_PDEATHSIG, SIGKILL); }

}  // namespace

void close_descriptors() {
    close(STDIN_FILENO);
    syscall(SYS_close_range, unsigned{STDERR_FILENO + 1}, ~0U, 0U);
}

void forbid_files() {
    // The first sizes and bits of each version; a kernel refuses those that it does not know.
    struct {
        std::uint64_t files;     // version 1: 13 kinds of access; 2: 14; 3: 15; 5: 16
        std::uint64_t networks;  // version 4: bind and connect by TCP
        std::uint64_t scopes;    // version 6: abstract sockets and signals to other processes
    } rules{};
    const long version =
        syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return;
    const int kinds = version == 1 ? 13 : version == 2 ? 14 : version < 5 ? 15 : 16;
    rules.files = (std::uint64_t{1} << kinds) - 1;
    if (version >= 4) rules.networks = 3;
    if (version >= 6) rules.scopes = 3;
    const std::size_t fields = version >= 6 ? 3 : version >= 4 ? 2 : 1;
    const long ruleset =
        syscall(SYS_landlock_create_ruleset, &rules, fields * sizeof(std::uint64_t), 0);
    if (ruleset < 0) return;
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    syscall(SYS_landlock_restrict_self, ruleset, 0);
    close(static_cast<int>(ruleset));
}

void filter_calls() {
    if (kProcessor == 0) return;
    CallFilter filter;
    for (const long call : kFree) filter.on(call, SECCOMP_RET_ALLOW);
#ifdef SYS_time
    filter.on(SYS_time, SECCOMP_RET_ALLOW);
#endif
    // Libraries write warnings to standard error, which is /dev/null.
    filter.allow_if_equal(SYS_write, 0, STDOUT_FILENO, STDERR_FILENO);
    filter.allow_if_equal(SYS_writev, 0, STDERR_FILENO, STDERR_FILENO);  // of abort messages
    filter.allow_if_equal(SYS_tgkill, 0, getpid(), getpid());
    filter.allow_if_equal(SYS_futex, 1, FUTEX_WAKE_PRIVATE, FUTEX_WAIT_PRIVATE);  // of call_once()
    filter.allow_unless_set(SYS_mmap, 2, PROT_EXEC);
    // HDF5 tests whether a file with the name of a file in memory exists, libsndfile whether the
    // file has a resource fork.
    filter.on(SYS_openat, SECCOMP_RET_ERRNO | EACCES);
#ifdef SYS_open
    filter.on(SYS_open, SECCOMP_RET_ERRNO | EACCES);
#endif
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    filter.install();
}

#endif

std::span<const std::byte> map_input() {
    struct stat status {};
    if (fstat(STDIN_FILENO, &status) != 0) std::_Exit(kNotMapped);
    if (status.st_size == 0) return {};
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const file = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, STDIN_FILENO, 0);
    if (file == MAP_FAILED) std::_Exit(kNotMapped);
    return {static_cast<const std::byte*>(file), size};
}

void limit_resources(std::size_t mapped_bytes, unsigned time_s) {
    const auto limit = [](auto resource, rlim_t soft, rlim_t hard) {
        const rlimit limits{soft, hard};
        setrlimit(resource, &limits);
    };
    const rlim_t memory = memory_limit(mapped_bytes);
    limit(RLIMIT_AS, memory, memory);
    // SIGXCPU at the first limit says why; SIGKILL at the second one cannot be ignored.
    limit(RLIMIT_CPU, time_s, rlim_t{time_s} + 1);
    limit(RLIMIT_CORE, 0, 0);
    limit(RLIMIT_FSIZE, 0, 0);
    limit(RLIMIT_NOFILE, 0, 0);
    end_with_parent();
    std::set_new_handler([] { std::_Exit(kOutOfMemory); });
}

std::span<const std::byte> contain() {
    const std::span<const std::byte> file = map_input();
    close_descriptors();
    forbid_files();
    limit_resources(file.size());
    filter_calls();
    return file;
}

bool write_bytes(const void* bytes, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(bytes);
    while (size > 0) {
        const ssize_t written = ::write(STDOUT_FILENO, from, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        from += written;
        size -= static_cast<std::size_t>(written);
    }
    return true;
}

}  // namespace aula
