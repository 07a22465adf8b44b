#include "audio/file/part_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <random>
#include <string>
#include <system_error>
#include <utility>

#include "audio/file/naming.h"

namespace aula {

namespace {

// List of all PartFiles, for abandon_all().
std::mutex mutex;
PartFile* first = nullptr;

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

constexpr const char* kExtension = ".part";

/// How the names of unfinished files of a target begin. The length does not depend on the target's.
std::string part_prefix(const std::filesystem::path& target) {
    // FNV-1a. Targets with equal hashes search each other's files, and keep those with a lock.
    std::uint32_t hash = 2166136261U;
    for (const char c : target.filename().string())
        hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
    std::array<char, 16> prefix{};
    std::snprintf(prefix.data(), prefix.size(), ".aula-%08x-", static_cast<unsigned>(hash));
    return prefix.data();
}

/// An unpredictable name of an unfinished file.
std::string random_name(const std::string& prefix) {
    std::random_device random;
    const std::uint64_t bits = std::uint64_t{random()} << 32U | random();
    std::array<char, 20> name{};
    std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(bits));
    return prefix + name.data() + kExtension;
}

/// Opens and locks a new file. Returns its descriptor, or -1 with `errno`; EEXIST if the name is
/// taken.
int create(const std::filesystem::path& file, mode_t mode) {
    const int descriptor =
        open(file.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC, mode);
    if (descriptor < 0 || lock_name(descriptor, file) != NameLock::busy) return descriptor;
    // Another process has taken it for the file of an ended one, before it was locked.
    close(descriptor);
    unlink(file.c_str());
    errno = EEXIST;
    return -1;
}

/// Removes the unfinished files that ended processes have left, which are those without a lock.
void remove_left_parts(const std::filesystem::path& folder, const std::string& prefix) {
    std::error_code error;
    std::filesystem::directory_iterator entry(folder, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (!name.starts_with(prefix) || !name.ends_with(kExtension)) continue;
        // Opening a pipe would block.
        const int descriptor =
            open(entry->path().c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (descriptor < 0) continue;
        if (lock_name(descriptor, entry->path()) == NameLock::locked) unlink(entry->path().c_str());
        close(descriptor);
    }
}

}  // namespace

std::filesystem::path file_behind_links(const std::filesystem::path& name) {
    constexpr int kMostLinks = 40;  // of Linux
    // The canonical form of a relative name may be relative, but that of "./" and a name is not.
    std::filesystem::path file = name.empty() ? name : std::filesystem::absolute(name);
    for (int links = 0; links < kMostLinks; ++links) {
        std::error_code error;
        file = std::filesystem::weakly_canonical(file, error);
        struct stat status {};
        if (!error && lstat(file.c_str(), &status) != 0) {
            if (errno == ENOENT || errno == ENOTDIR) return file;
            error.assign(errno, std::generic_category());
        }
        if (!error && !S_ISLNK(status.st_mode)) return file;
        // A link to a file that does not exist.
        if (!error) file = file.parent_path() / std::filesystem::read_symlink(file, error);
        if (error) fail(error.value());
    }
    fail(ELOOP);
}

PartFile::PartFile(const std::filesystem::path& file) : target_(file_behind_links(file)) {
    check_replaceable(file);
    const std::string prefix = part_prefix(target_);
    remove_left_parts(target_.parent_path(), prefix);
    struct stat replaced {};
    const bool replaces = stat(target_.c_str(), &replaced) == 0;
    // A new file has the user's default permissions, a replacement those of the replaced file.
    constexpr mode_t kNew = 0666;
    constexpr mode_t kPrivate = 0600;
    const std::lock_guard lock(mutex);
    do {
        temporary_ = target_.parent_path() / random_name(prefix);
        descriptor_ = create(temporary_, replaces ? kPrivate : kNew);
    } while (descriptor_ < 0 && errno == EEXIST);
    if (descriptor_ < 0) fail(errno);
    constexpr mode_t kPermissions = 0777;
    if (replaces && fchmod(descriptor_, replaced.st_mode & kPermissions) != 0) {
        const int reason = errno;
        close(descriptor_);
        unlink(temporary_.c_str());
        fail(reason);
    }
    next_ = std::exchange(first, this);
}

PartFile::~PartFile() {
    const std::lock_guard lock(mutex);
    PartFile** link = &first;
    while (*link != this) link = &(*link)->next_;
    *link = next_;
    if (!temporary_.empty()) unlink(temporary_.c_str());
    close(descriptor_);
}

void PartFile::commit() {
    {
        const std::lock_guard lock(mutex);
        complete_ = true;
    }
    // Otherwise a system crash may leave an empty file. Some file systems do not support it.
    if (fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOSYS) fail(errno);
    // Closing a duplicate reports late errors as closing the file does; the lock, which keeps other
    // processes from removing the file, ends with the last descriptor.
    const int duplicate = fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
    if (duplicate < 0 || close(duplicate) != 0) fail(errno);
    {
        const std::lock_guard lock(mutex);
        if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
        temporary_.clear();
    }
    flush_names(target_.parent_path());
}

void PartFile::abandon_all() {
    mutex.lock();
    for (const PartFile* file = first; file != nullptr; file = file->next_) {
        if (file->complete_) {
            std::rename(file->temporary_.c_str(), file->target_.c_str());
        } else {
            unlink(file->temporary_.c_str());
        }
    }
}

}  // namespace aula
