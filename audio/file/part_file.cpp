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
#include <system_error>
#include <utility>

namespace aula {

namespace {

// List of all PartFiles, for abandon_all().
std::mutex mutex;
PartFile* first = nullptr;

[[noreturn]] void fail(int error) { throw std::system_error(error, std::generic_category()); }

/// An unpredictable name whose length does not depend on the target's.
std::filesystem::path random_name(const std::filesystem::path& folder) {
    std::random_device random;
    const std::uint64_t bits = std::uint64_t{random()} << 32U | random();
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), ".aula-%016llx.part",
                  static_cast<unsigned long long>(bits));
    return folder / name.data();
}

/// Creates a file exclusively. Returns its descriptor, or -1.
int create(const std::filesystem::path& file, mode_t mode) {
    return open(file.c_str(), O_CREAT | O_EXCL | O_NOFOLLOW | O_RDWR | O_CLOEXEC, mode);
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
    struct stat replaced {};
    const bool replaces = stat(target_.c_str(), &replaced) == 0;
    // A new file has the user's default permissions, a replacement those of the replaced file.
    constexpr mode_t kNew = 0666;
    constexpr mode_t kPrivate = 0600;
    const std::lock_guard lock(mutex);
    do {
        temporary_ = random_name(target_.parent_path());
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
    if (descriptor_ >= 0) close(descriptor_);
    if (!temporary_.empty()) unlink(temporary_.c_str());
}

void PartFile::commit() {
    // Otherwise a system crash may leave an empty file. Some file systems do not support it.
    if (fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOSYS) fail(errno);
    if (close(std::exchange(descriptor_, -1)) != 0) fail(errno);
    const std::lock_guard lock(mutex);
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    temporary_.clear();
}

void PartFile::abandon_all() {
    mutex.lock();
    for (const PartFile* file = first; file != nullptr; file = file->next_)
        unlink(file->temporary_.c_str());
}

}  // namespace aula
