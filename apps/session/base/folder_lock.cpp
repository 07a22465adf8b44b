#include "apps/session/base/folder_lock.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "audio/file/naming.h"
#include "aula/exception.h"

namespace aula {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    if (descriptor_ < 0)
        throw InputError(folder.string(), "",
                         "cannot be opened, " + std::generic_category().message(errno) +
                             "; expected a folder that can be read");
    if (lock_name(descriptor_, folder) != NameLock::busy) return;
    close(descriptor_);
    throw InputError(folder.string(), "",
                     "another process writes here; expected one at a time, wait for its end");
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace aula
