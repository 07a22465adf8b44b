#include "apps/output/folder_lock.h"

#include <unistd.h>

#include <optional>
#include <system_error>

#include "aula/exception.h"
#include "process/files.h"

namespace aula {

FolderLock::FolderLock(const std::filesystem::path& folder) {
    std::optional<int> locked;
    try {
        locked = lock_folder(folder);
    } catch (const std::system_error& error) {
        throw InputError(
            folder.string(), "",
            "cannot be opened, " + error.code().message() + "; expected a folder that can be read");
    }
    if (!locked)
        throw InputError(folder.string(), "",
                         "another process writes here; expected one at a time, wait for its end");
    descriptor_ = *locked;
}

FolderLock::~FolderLock() { close(descriptor_); }

}  // namespace aula
