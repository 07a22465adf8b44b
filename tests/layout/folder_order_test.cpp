#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// A part of the project and its folders, each of which may include earlier ones. "" is the part's
/// root.
struct Part {
    std::string_view root;
    std::vector<std::string_view> folders;
    std::vector<std::string_view> may_include;  ///< other parts
};

const std::array kParts = {
    Part{"engine",
         {"process", "base", "input", "mesh", "scene", "response", "tail", "rays", "model", "edges",
          "direct", "patches", "trace", "cache", "estimate", "waves", ""},
         {"process"}},
    Part{"audio",
         {"base", "dsp", "convolution", "spatial", "render", "file", "device"},
         {"process"}},
    Part{"apps/output", {""}, {"engine", "audio", "process"}},
    Part{
        "apps/room",
        {"base", "waves", "frames", "auralizer", "images", "offline", "edit", "live", "remote", ""},
        {"apps/output", "engine", "audio", "process"}},
    Part{"apps/capi", {"include", ""}, {"apps/output", "apps/room", "engine", "audio", "process"}},
    Part{"apps/drawing", {""}, {"engine"}},
    Part{"apps/documents",
         {"", "report"},
         {"apps/drawing", "apps/output", "apps/room", "engine", "audio"}},
    Part{"apps/window",
         {"view", "model", "gl", ""},
         {"apps/documents", "apps/drawing", "apps/output", "apps/room", "engine", "audio",
          "process"}},
    Part{"apps/bench",
         {"base", "convolution", "propagation", "rendering", "waves", ""},
         {"apps/output", "apps/room", "engine", "audio", "process"}},
    Part{"apps/examples", {""}, {"apps/room", "engine", "audio"}},
    Part{"apps/plugin",
         {"", "editor", "lv2", "clap", "vst3"},
         {"apps/drawing", "apps/output", "apps/room", "engine", "audio", "process"}},
    Part{"apps/godot", {"interface", "sound", "bind", ""}, {}},
    Part{"apps/unity", {""}, {"process"}},
    Part{"apps/python", {""}, {"apps/output", "apps/room", "engine", "audio"}},
    Part{"apps/dataset",
         {"base", "plan", "shards", "merge"},
         {"apps/output", "apps/room", "engine", "audio", "process"}},
    Part{"apps/aula",
         {"arguments", "terminal", ""},
         {"apps/dataset", "apps/documents", "apps/drawing", "apps/output", "apps/room",
          "apps/window", "engine", "audio", "process"}},
};

bool is_source(const fs::path& file) {
    return file.extension() == ".h" || file.extension() == ".cpp";
}

/// "folder/file" of a path below a root; the folder is "" in the root itself.
std::string folder_of(const std::string& path, std::string_view root) {
    const std::string rest = path.substr(root.size() + 1);
    const std::size_t slash = rest.rfind('/');
    return slash == std::string::npos ? "" : rest.substr(0, slash);
}

bool lies_in(const std::string& path, std::string_view root) {
    return path.size() > root.size() && path.starts_with(root) && path[root.size()] == '/';
}

/// The include folder of a part's public headers, which programs include as <aula/...>.
const std::string_view kPublic = "/include/aula";

/// Files in quotes that a source includes.
std::vector<std::string> includes(const fs::path& file) {
    constexpr std::string_view kBegin = "#include \"";
    std::vector<std::string> found;
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with(kBegin)) continue;
        const std::size_t end = line.find('"', kBegin.size());
        found.push_back(line.substr(kBegin.size(), end - kBegin.size()));
    }
    return found;
}

std::size_t rank(const Part& part, const std::string& folder) {
    const auto at = std::find(part.folders.begin(), part.folders.end(), folder);
    INFO("folder \"" << folder << "\" of " << part.root);
    REQUIRE(at != part.folders.end());
    return static_cast<std::size_t>(at - part.folders.begin());
}

/// A public header's file of "aula/..."; empty if there is none.
std::string public_header(const std::string& included) {
    for (const Part& part : kParts) {
        const std::string file = std::string(part.root) + "/include/" + included;
        if (fs::exists(fs::path(AULA_SOURCE_DIR) / file)) return file;
    }
    return {};
}

/// The rank of a file in its part. A public header has that of its source file; without one, that
/// of the highest public header that it includes.
std::size_t rank_of(const Part& part, const std::string& file) {
    const std::string folder = folder_of(file, part.root);
    if (!("/" + folder).starts_with(kPublic)) return rank(part, folder);
    const fs::path source = fs::path(file).filename().replace_extension(".cpp");
    for (const std::string_view home : part.folders) {
        if (fs::exists(fs::path(AULA_SOURCE_DIR) / part.root / home / source))
            return rank(part, std::string(home));
    }
    std::size_t highest = 0;
    for (const std::string& included : includes(fs::path(AULA_SOURCE_DIR) / file)) {
        const std::string other = public_header(included);
        if (lies_in(other, part.root)) highest = std::max(highest, rank_of(part, other));
    }
    return highest;
}

}  // namespace

TEST_CASE("a folder includes only earlier folders of its part and parts that it depends on") {
    const fs::path project = AULA_SOURCE_DIR;
    std::size_t checked = 0;
    for (const Part& part : kParts) {
        for (const auto& entry : fs::recursive_directory_iterator(project / part.root)) {
            if (!is_source(entry.path())) continue;
            const std::string file = fs::relative(entry.path(), project).generic_string();
            const bool is_public = ("/" + folder_of(file, part.root)).starts_with(kPublic);
            const std::size_t own = rank_of(part, file);
            for (const std::string& included : includes(entry.path())) {
                INFO(file << " includes " << included);
                ++checked;
                const std::string header = public_header(included);
                const std::string& target = header.empty() ? included : header;
                if (is_public) CHECK_FALSE(header.empty());
                if (lies_in(target, part.root)) {
                    CHECK(rank_of(part, target) <= own);
                    continue;
                }
                const bool allowed =
                    included == "aula/exception.h" ||
                    std::any_of(part.may_include.begin(), part.may_include.end(),
                                [&](std::string_view other) { return lies_in(target, other); });
                // Headers of other projects must not be included in quotes.
                CHECK(allowed);
            }
        }
    }
    CHECK(checked > 500);
}

TEST_CASE("no folder holds more than 24 sources") {
    const fs::path project = AULA_SOURCE_DIR;
    for (const std::string_view top : {"engine", "audio", "apps", "tests"}) {
        for (const auto& folder : fs::recursive_directory_iterator(project / top)) {
            if (!folder.is_directory()) continue;
            const auto sources =
                std::count_if(fs::directory_iterator(folder.path()), fs::directory_iterator(),
                              [](const auto& entry) { return is_source(entry.path()); });
            INFO(folder.path());
            CHECK(sources <= 24);
        }
    }
}
