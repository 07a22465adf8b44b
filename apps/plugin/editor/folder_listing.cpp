#include "apps/plugin/editor/folder_listing.h"

#include <algorithm>
#include <system_error>

#include "engine/mesh/mesh_import.h"

namespace aula::plugin {

namespace fs = std::filesystem;

namespace {

void sort(std::vector<FolderListing::Entry>& entries) {
    std::sort(entries.begin(), entries.end(),
              [](const auto& a, const auto& b) { return a.path < b.path; });
}

}  // namespace

FolderListing list_folder(const fs::path& folder, const std::vector<fs::path>& drives) {
    FolderListing listing;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        const fs::path& path = at->path();
        std::string name;
        try {
            name = path.filename().string();
        } catch (const std::system_error&) {
            continue;  // Windows has names that are no Unicode
        }
        if (name.starts_with(".")) continue;
        std::error_code none;
        if (at->is_directory(none))
            listing.folders.push_back({path, name + "/"});
        else if (path.extension() == ".json" || is_mesh_file(path))
            listing.files.push_back({path, name});
    }
    sort(listing.folders);
    sort(listing.files);
    std::vector<FolderListing::Entry> above;
    if (folder != folder.root_path()) {
        above.push_back({folder.parent_path(), ".."});
    } else {
        for (const fs::path& drive : drives)
            if (drive != folder) above.push_back({drive, drive.string()});
    }
    listing.folders.insert(listing.folders.begin(), above.begin(), above.end());
    return listing;
}

}  // namespace aula::plugin
