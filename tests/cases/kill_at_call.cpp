// A library to be preloaded into a program: kills it before its n-th call that changes files.
//
// AULA_KILL_AT=N             the number of the call, from 1 on
// AULA_KILL_CALLS=all        also counts calls that write, create and close; else those that
//                            remove, rename and flush
// AULA_KILL_COUNT=FILE       at the program's end the number of calls is written to this file
// AULA_KILL_NO_EXCHANGE=1    renameat2() has no flags, as on some file systems

#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>

namespace {

std::atomic<long> calls = 0;

const char* setting(const char* name) {
    const char* const value = getenv(name);
    return value != nullptr ? value : "";
}

void count_call() {
    static const long at = atol(setting("AULA_KILL_AT"));
    if (++calls == at) kill(getpid(), SIGKILL);
}

void count_write() {
    static const bool counts = strcmp(setting("AULA_KILL_CALLS"), "all") == 0;
    if (counts) count_call();
}

/// The function of the C library that has this name.
template <typename Function>
Function next(const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct AtEnd {
    ~AtEnd() {
        const char* const file = setting("AULA_KILL_COUNT");
        if (*file == '\0') return;
        if (FILE* const out = fopen(file, "w"); out != nullptr) {
            fprintf(out, "%ld\n", calls.load());
            fclose(out);
        }
    }
} at_end;

}  // namespace

// The function `name` of the C library, counted by `count`.
#define AULA_COUNTED(count, result, name, parameters, arguments)        \
    extern "C" result name parameters {                                 \
        static const auto original = next<result(*) parameters>(#name); \
        count();                                                        \
        return original arguments;                                      \
    }

AULA_COUNTED(count_call, int, unlink, (const char* file), (file))
AULA_COUNTED(count_call, int, unlinkat, (int folder, const char* file, int flags),
             (folder, file, flags))
AULA_COUNTED(count_call, int, rmdir, (const char* folder), (folder))
AULA_COUNTED(count_call, int, remove, (const char* file), (file))
AULA_COUNTED(count_call, int, rename, (const char* from, const char* to), (from, to))
AULA_COUNTED(count_call, int, fsync, (int descriptor), (descriptor))
AULA_COUNTED(count_call, int, syncfs, (int descriptor), (descriptor))
AULA_COUNTED(count_write, int, close, (int descriptor), (descriptor))
AULA_COUNTED(count_write, int, mkdir, (const char* folder, mode_t mode), (folder, mode))
AULA_COUNTED(count_write, int, fchmod, (int descriptor, mode_t mode), (descriptor, mode))
AULA_COUNTED(count_write, ssize_t, write, (int descriptor, const void* data, size_t size),
             (descriptor, data, size))
AULA_COUNTED(count_write, ssize_t, pwrite,
             (int descriptor, const void* data, size_t size, off_t at),
             (descriptor, data, size, at))
AULA_COUNTED(count_write, ssize_t, writev, (int descriptor, const iovec* data, int count),
             (descriptor, data, count))

extern "C" int renameat2(int from_folder, const char* from, int to_folder, const char* to,
                         unsigned flags) {
    count_call();
    if (flags != 0 && *setting("AULA_KILL_NO_EXCHANGE") != '\0') {
        errno = EINVAL;
        return -1;
    }
    return static_cast<int>(syscall(SYS_renameat2, from_folder, from, to_folder, to, flags));
}

extern "C" int open(const char* file, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if ((flags & O_CREAT) != 0) count_write();
    return static_cast<int>(syscall(SYS_openat, AT_FDCWD, file, flags, mode));
}
