#include "tests/cases/killed_program.h"

#include <catch2/catch.hpp>
#include <csignal>

namespace aula::test {

namespace {

namespace fs = std::filesystem;

ProgramResult run_counted(const std::vector<std::string>& command, const Kill& kill,
                          const std::vector<std::string>& settings) {
    std::vector<std::string> all{"env", "LD_PRELOAD=" AULA_KILL_AT_CALL};
    if (kill.calls == Kill::Calls::all) all.emplace_back("AULA_KILL_CALLS=all");
    if (!kill.exchanges) all.emplace_back("AULA_KILL_NO_EXCHANGE=1");
    all.insert(all.end(), settings.begin(), settings.end());
    all.insert(all.end(), command.begin(), command.end());
    return run_program(all);
}

}  // namespace

bool killed(const std::vector<std::string>& command, const Kill& kill, long at) {
    const ProgramResult result = run_counted(command, kill, {"AULA_KILL_AT=" + std::to_string(at)});
    if (result.by_signal && result.status == 128 + SIGKILL) return true;
    INFO(result.err);
    REQUIRE(result.status == 0);
    return false;
}

long calls_of(const std::vector<std::string>& command, const Kill& kill) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "count";
    const ProgramResult result = run_counted(command, kill, {"AULA_KILL_COUNT=" + file.string()});
    INFO(result.err);
    REQUIRE(result.status == 0);
    return std::stol(read_file(file));
}

FolderContents contents_of(const fs::path& folder) {
    FolderContents contents;
    if (!fs::exists(folder)) return contents;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string name = entry.path().lexically_relative(folder).string();
        if (entry.is_directory())
            contents[name + "/"];
        else
            contents[name] = read_file(entry.path());
    }
    return contents;
}

void restore(const fs::path& folder, const FolderContents& contents) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    // In the order of the names a folder precedes its files.
    for (const auto& [name, content] : contents) {
        if (name.ends_with('/'))
            fs::create_directory(folder / name);
        else
            std::ofstream(folder / name, std::ios::binary) << content;
    }
}

}  // namespace aula::test
