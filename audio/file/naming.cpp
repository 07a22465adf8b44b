#include "audio/file/naming.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "aula/exception.h"

namespace aula {

namespace {

[[noreturn]] void fail_to_name(int error) {
    throw std::system_error(error, std::generic_category());
}

/// Whether an open file still has the name.
bool has_name(int descriptor, const std::filesystem::path& name) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && stat(name.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

NameLock lock_name(int descriptor, const std::filesystem::path& name) {
    const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    if (!locked && errno == EWOULDBLOCK) return NameLock::busy;
    if (!has_name(descriptor, name)) return NameLock::busy;
    return locked ? NameLock::locked : NameLock::unsupported;
}

void check_replaceable(const std::filesystem::path& target) {
    struct stat status {};
    if (stat(target.c_str(), &status) != 0 || (status.st_mode & S_IWUSR) != 0) return;
    constexpr mode_t kPermissions = 07777;
    std::array<char, 8> mode{};
    std::snprintf(mode.data(), mode.size(), "%04o", status.st_mode & kPermissions);
    throw InputError(target.string(), "",
                     "is write-protected (mode " + std::string(mode.data()) +
                         ") and would be replaced; expected write permission for its owner "
                         "(chmod u+w)");
}

void rename_flushed(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (std::rename(from.c_str(), to.c_str()) != 0) fail_to_name(errno);
    flush_names(to.parent_path());
}

void flush_names(const std::filesystem::path& folder) {
    const int descriptor =
        open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    // A folder may be writable and not readable.
    if (descriptor < 0 && errno == EACCES) return;
    if (descriptor < 0) fail_to_name(errno);
    // Some file systems do not support it.
    const bool flushed = fsync(descriptor) == 0 || errno == EINVAL || errno == ENOSYS;
    const int error = errno;
    close(descriptor);
    if (!flushed) fail_to_name(error);
}

}  // namespace aula
