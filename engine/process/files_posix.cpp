#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#if defined(__APPLE__)
#include <mach-o/dyld.h>
#endif

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <string>
#include <system_error>
#include <utility>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

int checked(int descriptor) {
    if (descriptor < 0) fail(errno);
    return descriptor;
}

/// What file systems and kernels say of calls that they do not support.
bool is_unsupported(int error) {
#if defined(__APPLE__)
    if (error == ENOTSUP) return true;
#endif
    return error == EINVAL || error == ENOSYS;
}

int open_folder(const std::filesystem::path& folder) {
    return open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

/// fsync(), which on macOS leaves the bytes to the cache of the disk, unless the file system has no
/// better.
int flush(int descriptor) {
#if defined(__APPLE__)
    if (fcntl(descriptor, F_FULLFSYNC) == 0) return 0;
#endif
    return fsync(descriptor);
}

/// Renames, unless the name is taken. Returns 0, or -1 and errno.
int rename_exclusively(const char* from, const char* to) {
#if defined(__APPLE__)
    return renamex_np(from, to, RENAME_EXCL);
#else
    return renameat2(AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE);
#endif
}

int exchange(const char* one, const char* other) {
#if defined(__APPLE__)
    return renamex_np(one, other, RENAME_SWAP);
#else
    return renameat2(AT_FDCWD, one, AT_FDCWD, other, RENAME_EXCHANGE);
#endif
}

/// Creates a file in memory, or on macOS, which has none, a temporary file without a name.
int create_anonymous() {
#if defined(__APPLE__)
    std::string name = (std::filesystem::temp_directory_path() / "aula-XXXXXX").string();
    const int descriptor = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor >= 0) unlink(name.c_str());
    return descriptor;
#else
    return memfd_create("aula", MFD_CLOEXEC);
#endif
}

/// Whether an open file still has the name.
bool has_name(int descriptor, const std::filesystem::path& name) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && stat(name.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

bool has_entry(const std::filesystem::path& name) {
    std::error_code ignored;
    return std::filesystem::exists(std::filesystem::symlink_status(name, ignored));
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

std::filesystem::path program_file(std::error_code& error) {
#if defined(__APPLE__)
    std::array<char, 4096> name{};
    std::uint32_t size = name.size();
    if (_NSGetExecutablePath(name.data(), &size) == 0)
        return std::filesystem::canonical(name.data(), error);
    error = std::make_error_code(std::errc::filename_too_long);
    return {};
#else
    return std::filesystem::read_symlink("/proc/self/exe", error);
#endif
}

std::size_t most_open_files() {
    rlimit files{.rlim_cur = 256, .rlim_max = 256};
    getrlimit(RLIMIT_NOFILE, &files);
    return files.rlim_cur;
}

std::error_code folder_refusal(const std::filesystem::path& folder) {
    if (access(folder.c_str(), W_OK | X_OK) == 0) return {};
    return {errno, std::generic_category()};
}

int open_to_read(const std::filesystem::path& file) {
    return checked(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
}

int open_device(const std::filesystem::path& file) {
    return checked(open(file.c_str(), O_WRONLY | O_CLOEXEC));
}

std::optional<int> create_file(const std::filesystem::path& file, bool replaces) {
    // A new file has the user's default permissions.
    constexpr mode_t kNew = 0666;
    constexpr mode_t kPrivate = 0600;
    const int descriptor = open(file.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC,
                                replaces ? kPrivate : kNew);
    if (descriptor < 0 && errno == EEXIST) return std::nullopt;
    return checked(descriptor);
}

Descriptor anonymous_file(std::string_view bytes) {
    Descriptor file(checked(create_anonymous()));
    write_all(file.number(), bytes);
    return file;
}

std::optional<std::uint64_t> regular_size(int descriptor) {
    struct stat status {};
    if (fstat(descriptor, &status) != 0) fail(errno);
    if (!S_ISREG(status.st_mode)) return std::nullopt;
    return static_cast<std::uint64_t>(status.st_size);
}

std::size_t read_at(int descriptor, void* bytes, std::size_t size, std::uint64_t offset) {
    ssize_t got = -1;
    do {
        got = pread(descriptor, bytes, size, static_cast<off_t>(offset));
    } while (got < 0 && errno == EINTR);
    if (got < 0) fail(errno);
    return static_cast<std::size_t>(got);
}

void write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) fail(errno);
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
}

void close_file(int descriptor) {
    if (close(descriptor) != 0) fail(errno);
}

void flush_file(int descriptor) {
    if (flush(descriptor) != 0 && !is_unsupported(errno)) fail(errno);
    // Closing a duplicate reports late errors as closing the file does; the lock, which keeps other
    // processes from removing the file, ends with the last descriptor.
    close_file(checked(fcntl(descriptor, F_DUPFD_CLOEXEC, 0)));
}

void flush_files(const std::filesystem::path& folder) {
    // Of the whole file system: one by one takes longer.
    const int descriptor = checked(open_folder(folder));
#if defined(__APPLE__)
    const bool flushed = fsync_volume_np(descriptor, SYNC_VOLUME_FULLSYNC | SYNC_VOLUME_WAIT) == 0;
#else
    const bool flushed = syncfs(descriptor) == 0;
#endif
    const int error = errno;
    close(descriptor);
    if (!flushed) fail(error);
}

void flush_names(const std::filesystem::path& folder) {
    const int descriptor = open_folder(folder);
    // A folder may be writable and not readable.
    if (descriptor < 0 && errno == EACCES) return;
    checked(descriptor);
    // Some file systems do not support it.
    const bool flushed = flush(descriptor) == 0 || is_unsupported(errno);
    const int error = errno;
    close(descriptor);
    if (!flushed) fail(error);
}

void copy_permissions(int descriptor, const std::filesystem::path& from) {
    constexpr mode_t kPermissions = 0777;
    struct stat status {};
    if (stat(from.c_str(), &status) != 0) return;
    if (fchmod(descriptor, status.st_mode & kPermissions) != 0) fail(errno);
}

void copy_folder_permissions(const std::filesystem::path& folder, const std::filesystem::path& from,
                             bool usable) {
    constexpr mode_t kPermissions = 07777;
    struct stat status {};
    if (stat(from.c_str(), &status) != 0) return;
    mode_t mode = status.st_mode & kPermissions;
    if (usable) mode |= S_IRWXU;
    if (chmod(folder.c_str(), mode) != 0) fail(errno);
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
    if (std::rename(from.c_str(), to.c_str()) != 0) fail(errno);
    flush_names(to.parent_path());
}

bool rename_to_free_name(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (rename_exclusively(from.c_str(), to.c_str()) == 0) return true;
    if (errno == EEXIST) return false;
    // Some file systems and kernels do not support the flag.
    if (!is_unsupported(errno)) fail(errno);
    if (has_entry(to)) return false;
    std::filesystem::rename(from, to);
    return true;
}

bool exchange_names(const std::filesystem::path& one, const std::filesystem::path& other) noexcept {
    return exchange(one.c_str(), other.c_str()) == 0;
}

NameLock lock_name(int descriptor, const std::filesystem::path& name) {
    const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) == 0;
    if (!locked && errno == EWOULDBLOCK) return NameLock::busy;
    if (!has_name(descriptor, name)) return NameLock::busy;
    return locked ? NameLock::locked : NameLock::unsupported;
}

int open_locked(const std::filesystem::path& file) {
    // Opening a pipe would block.
    const int descriptor = open(file.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0 || lock_name(descriptor, file) == NameLock::locked) return descriptor;
    close(descriptor);
    return -1;
}

std::optional<int> lock_folder(const std::filesystem::path& folder) {
    const int descriptor = checked(open_folder(folder));
    if (lock_name(descriptor, folder) != NameLock::busy) return descriptor;
    close(descriptor);
    return std::nullopt;
}

}  // namespace aula
