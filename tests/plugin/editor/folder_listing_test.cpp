#include "apps/plugin/editor/folder_listing.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace folder_listing_test {

namespace {

using namespace aula;
using namespace aula::test;
namespace fs = std::filesystem;

std::vector<std::string> names(const std::vector<plugin::FolderListing::Entry>& entries) {
    std::vector<std::string> names;
    for (const auto& entry : entries) names.push_back(entry.name);
    return names;
}

}  // namespace

TEST_CASE("An editor lists the scenes and models of a folder, and the folders around") {
    const TemporaryFolder folder;
    for (const std::string name : {"b.json", "Hall.OBJ", "a.glb", "voice.wav", ".hidden.json"})
        folder.write(name, "");
    fs::create_directory(folder.path() / "rooms");
    fs::create_directory(folder.path() / ".cache");
    const plugin::FolderListing listing = plugin::list_folder(folder.path(), {"C:\\", "D:\\"});
    CHECK(names(listing.folders) == std::vector<std::string>{"..", "rooms/"});
    CHECK(listing.folders[0].path == folder.path().parent_path());
    CHECK(listing.folders[1].path == folder.path() / "rooms");
    CHECK(names(listing.files) == std::vector<std::string>{"Hall.OBJ", "a.glb", "b.json"});
    CHECK(listing.files[2].path == folder.path() / "b.json");
    // The folder may be gone.
    const plugin::FolderListing gone = plugin::list_folder(folder.path() / "gone", {});
    CHECK(names(gone.folders) == std::vector<std::string>{".."});
    CHECK(gone.files.empty());
}

TEST_CASE("Above the root of a drive an editor lists the other drives") {
    const fs::path root = fs::current_path().root_path();
    const auto folders = [&](const std::vector<fs::path>& drives) {
        return names(plugin::list_folder(root, drives).folders);
    };
    std::vector<std::string> inside = folders({});
    CHECK(std::find(inside.begin(), inside.end(), "..") == inside.end());
    inside.insert(inside.begin(), "other");
    CHECK(folders({root, "other"}) == inside);
}

}  // namespace folder_listing_test
