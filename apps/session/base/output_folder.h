#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/session/base/folder_lock.h"

namespace aula {

/// A folder that appears whole under its name at commit(); without commit() nothing remains, and an
/// earlier folder of that name stays. It is written under a hidden name beside it.
class OutputFolder {
 public:
    /// Creates missing folders above it. Removes what a killed process has left, or gives the
    /// earlier folder its name again. Throws InputError if the folder cannot be created, or if
    /// another process writes it.
    explicit OutputFolder(std::filesystem::path folder);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// The path of a file to write now.
    std::filesystem::path path(const std::string& name) const { return part_ / name; }

    /// Flushes the files to the disk, gives the folder its name in the place of an earlier one, and
    /// removes that. Throws Failure.
    void commit();

 private:
    void prepare();
    void replace();
    void remove_part() noexcept;

    std::filesystem::path folder_;
    std::filesystem::path part_;                  ///< the folder until commit()
    std::filesystem::path earlier_;               ///< the earlier one during commit()
    std::vector<std::filesystem::path> parents_;  ///< new ones, innermost first
    std::optional<FolderLock> lock_;              ///< of part_
};

}  // namespace aula
