#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "apps/dataset/base/folder_lock.h"

namespace aula {

/// A folder that appears under its name at commit(); without commit() nothing remains. It lists the
/// SHA-256 of its files in SHA256SUMS. It replaces a folder that contains listed files only.
class MergedFolder {
 public:
    /// Throws InputError if it cannot be created or would replace other files, or if another
    /// process writes it.
    explicit MergedFolder(std::filesystem::path folder);
    ~MergedFolder();
    MergedFolder(const MergedFolder&) = delete;
    MergedFolder& operator=(const MergedFolder&) = delete;

    /// The path of a file to write now.
    std::filesystem::path path(const std::string& name) const { return part_ / name; }

    /// Writes a file; the name may have a folder. Throws Failure.
    void write(const std::string& name, std::string_view content);

    /// Appends a file that has been written at path() to SHA256SUMS. Throws Failure.
    void list(const std::string& name);

    /// Writes SHA256SUMS and renames the folder, which replaces an earlier one. Throws Failure.
    void commit();

 private:
    std::filesystem::path folder_;
    std::filesystem::path part_;
    std::optional<FolderLock> lock_;  ///< of part_
    std::string sums_;
};

}  // namespace aula
