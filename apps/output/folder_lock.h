#pragma once

#include <filesystem>

namespace aula {

/// Exclusive use of an existing folder among the processes that ask for it. Processes on other
/// machines are excluded where the file system supports it.
class FolderLock {
 public:
    /// Throws InputError if the folder cannot be opened, or if another process uses it or has
    /// renamed or removed it meanwhile.
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

 private:
    int descriptor_ = -1;
};

}  // namespace aula
