#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace aula::plugin {

/// What an editor lists of a folder, sorted by name.
struct FolderListing {
    struct Entry {
        std::filesystem::path path;
        std::string name;  ///< that is shown, UTF-8
    };
    /// First the folder above; in place of it the other drives, where there are some.
    std::vector<Entry> folders;
    /// Scene files and models.
    std::vector<Entry> files;
};

/// Names that begin with a dot are left out. A folder that cannot be read has nothing but the one
/// above it. `drives`: those of the system, if it has more roots than one.
FolderListing list_folder(const std::filesystem::path& folder,
                          const std::vector<std::filesystem::path>& drives);

}  // namespace aula::plugin
