#include "apps/window/model/new_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

namespace {

/// Opens and locks a file that does not exist, or that an ended program has left empty. Returns its
/// descriptor, or -1 with `errno`; EEXIST if the name is taken.
int reserve(const std::filesystem::path& path) {
    constexpr mode_t kMode = 0666;
    int descriptor = open(path.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, kMode);
    if (descriptor >= 0 && lock_name(descriptor, path) != NameLock::busy) return descriptor;
    if (descriptor < 0 && errno != EEXIST) return -1;
    // Opening a pipe would block.
    if (descriptor < 0)
        descriptor = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    struct stat status {};
    if (descriptor >= 0 && lock_name(descriptor, path) == NameLock::locked &&
        fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0)
        return descriptor;
    if (descriptor >= 0) close(descriptor);
    errno = EEXIST;
    return -1;
}

}  // namespace

NewFile::NewFile(const std::string& stem, const std::string& extension) {
    for (int number = 1; descriptor_ < 0; ++number) {
        path_ = stem + (number > 1 ? '-' + std::to_string(number) : "") + extension;
        descriptor_ = reserve(path_);
        if (descriptor_ >= 0 || errno == EEXIST) continue;
        throw InputError(path_.string(), "",
                         "cannot be written: " + std::generic_category().message(errno) +
                             "; expected a working directory that can be written to");
    }
}

NewFile::~NewFile() {
    std::error_code error;
    if (std::filesystem::file_size(path_, error) == 0 && !error)
        std::filesystem::remove(path_, error);
    close(descriptor_);
}

}  // namespace aula
