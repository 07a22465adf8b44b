#include "apps/dataset/base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "aula/exception.h"

namespace aula {

namespace {

/// Whether a folder still has the name by which it was opened.
bool has_name(int descriptor, const std::filesystem::path& folder) {
    struct stat opened {};
    struct stat named {};
    return fstat(descriptor, &opened) == 0 && stat(folder.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0)
        throw InputError(folder.string(), "",
                         "cannot be opened, " + std::generic_category().message(errno) +
                             "; expected a folder that can be read");
    // File systems without locks give other errors.
    const bool busy = flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!busy && has_name(descriptor_, folder)) return;
    close(descriptor_);
    throw InputError(folder.string(), "",
                     "another process writes here; expected one at a time, wait for its end");
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace aula
