// Preloaded into a program, this library blocks its reading of the file that AULA_BLOCKED_FILE
// names, as a disk that does not answer would, and then creates FILE.blocked.

#include <fcntl.h>
#include <sys/syscall.h>

#include <climits>
#include <cstdlib>
#include <string>

extern "C" {

// Declared here, since the system's header may define them inline.
long syscall(long number, ...);
int pause();
int close(int descriptor);
long readlink(const char* path, char* target, unsigned long size);

long pread(int descriptor, void* bytes, unsigned long count, long offset) {
    if (const char* const blocked = std::getenv("AULA_BLOCKED_FILE")) {
        char target[PATH_MAX];
        const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
        const long length = readlink(link.c_str(), target, sizeof(target));
        if (length > 0 && std::string(target, static_cast<std::size_t>(length)) == blocked) {
            close(open((std::string(blocked) + ".blocked").c_str(), O_CREAT | O_WRONLY, 0600));
            for (;;) pause();
        }
    }
    return syscall(SYS_pread64, descriptor, bytes, count, offset);
}

long pread64(int descriptor, void* bytes, unsigned long count, long offset) {
    return pread(descriptor, bytes, count, offset);
}

long __pread_chk(int descriptor, void* bytes, unsigned long count, long offset, unsigned long) {
    return pread(descriptor, bytes, count, offset);
}

long __pread64_chk(int descriptor, void* bytes, unsigned long count, long offset, unsigned long) {
    return pread(descriptor, bytes, count, offset);
}
}
