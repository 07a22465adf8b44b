#pragma once

#include <filesystem>

namespace aula {

/// Exclusive use of an existing folder among the processes that ask for it. Processes on other
/// machines are excluded where the file system supports it.
class FolderLock {
 public:
    /// Throws InputError if another process uses the folder, or has renamed or removed it
    /// meanwhile.
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

 private:
    int descriptor_ = -1;
};

}  // namespace aula
