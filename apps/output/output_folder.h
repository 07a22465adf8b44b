#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/output/folder_lock.h"

namespace aula {

/// A folder that appears whole under its name at commit(); without commit() nothing remains, and an
/// earlier folder of that name stays. It is written under a hidden name beside it. It replaces only
/// a folder that exists from the beginning, and has the permissions of that folder.
class OutputFolder {
 public:
    /// Creates missing folders above it. Removes what a killed process has left, or gives the
    /// earlier folder its name again. Throws InputError if the folder cannot be created, if another
    /// process writes it, or if anything but a folder has one of the hidden names.
    explicit OutputFolder(const std::filesystem::path& folder);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// The path of a file to write now.
    std::filesystem::path path(const std::string& name) const { return part_ / name; }

    /// Whether commit() replaces a folder.
    bool replaces() const { return replaces_; }

    /// Flushes the files to the disk, gives the folder its name in the place of an earlier one, and
    /// removes that. Throws Failure. If another program has created a folder of that name
    /// meanwhile, both remain, the new one under its hidden name.
    void commit();

 private:
    void prepare();
    void replace();
    void rename_new();
    void remove_part() noexcept;

    std::filesystem::path folder_;
    std::filesystem::path part_;                  ///< the folder until commit()
    std::filesystem::path earlier_;               ///< the earlier one during commit()
    std::vector<std::filesystem::path> parents_;  ///< new ones, innermost first
    std::optional<FolderLock> lock_;              ///< of part_
    bool replaces_ = false;
};

}  // namespace aula
