#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/cases/killed_program.h"
#include "tests/support/small_scenes.h"

namespace {

using namespace aula::test;
using Catch::Contains;
namespace fs = std::filesystem;

/// A command that writes to the folder `out`. Other seeds give other contents.
struct Command {
    std::vector<std::string> words;
    bool is_slow = false;     ///< takes 2 s of processor time
    bool new_folder = false;  ///< whether the folder of its files does not exist before
};

std::vector<std::string> with_seed(const Command& command, const std::string& seed) {
    std::vector<std::string> words{AULA_PROGRAM};
    words.insert(words.end(), command.words.begin(), command.words.end());
    words.insert(words.end(), {"--seed", seed, "--rays", "20", "--threads", "1"});
    return words;
}

std::vector<Command> commands(const std::string& scene, const fs::path& out) {
    const std::vector<std::string> map{"map",       scene, "--frames", "1",
                                       "--spacing", "3",   "--out",    out / "maps"};
    return {
        {.words = {scene, "--offline", out / "o.wav", "--duration", "0.1", "--output", "mono"}},
        {.words = {scene, "--frames", "1", "--ir", out / "i.wav", "--output", "mono", "--echogram",
                   out / "e.csv"}},
        {.words = {"report", scene, "--frames", "1", "--html", out / "r.html"}, .is_slow = true},
        {.words = map, .is_slow = true},
        {.words = map, .is_slow = true, .new_folder = true}};
}

/// The calls before which a command is killed: each one, and after the last; of a slow command the
/// last two, which rename and flush, and one in the middle.
std::vector<long> kill_points(const Command& command) {
    const long calls = calls_of(with_seed(command, "2"), {});
    if (command.is_slow) return {calls / 2, calls - 1, calls};
    std::vector<long> points;
    for (long at = 1; at <= calls + 1; ++at) points.push_back(at);
    return points;
}

}  // namespace

TEST_CASE("a program killed at each removal, renaming and flush leaves the old files or the new") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const fs::path out = folder.path() / "out";
    for (const Command& command : commands(scene, out)) {
        CAPTURE(command.words);
        fs::create_directory(out);
        if (!command.new_folder) REQUIRE(run_program(with_seed(command, "1")).status == 0);
        const FolderContents earlier = contents_of(out);
        const std::vector<long> points = kill_points(command);
        const FolderContents next = contents_of(out);
        REQUIRE(next != earlier);
        for (const long at : points) {
            CAPTURE(at);
            restore(out, earlier);
            const bool is_after_last = !command.is_slow && at == points.back();
            CHECK(killed(with_seed(command, "2"), {}, at) != is_after_last);
            FolderContents left = contents_of(out);
            for (const auto& [name, content] : next) {
                CAPTURE(name);
                const bool is_whole = earlier.contains(name)
                                          ? left[name] == earlier.at(name) || left[name] == content
                                          : !left.contains(name) || left[name] == content;
                CHECK(is_whole);
            }
            // A new folder of several files appears whole.
            if (command.new_folder && left.contains("maps/"))
                for (const auto& entry : next) CHECK(left.contains(entry.first));
            if (command.is_slow && at != points.front()) continue;
            REQUIRE(run_program(with_seed(command, "2")).status == 0);
            CHECK(contents_of(out) == next);
        }
        fs::remove_all(out);
    }
}

TEST_CASE("a map creates its folder where the file system cannot keep a name while renaming") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const std::vector<std::string> map = with_seed(commands(scene, folder.path()).back(), "1");
    const long beyond = calls_of(map, {}) + 100;
    fs::remove_all(folder.path() / "maps");
    CHECK_FALSE(killed(map, {.exchanges = false}, beyond));
    CHECK(names_in(folder.path()) == std::vector<std::string>{"maps", "room.json"});
}

TEST_CASE("an output that its owner may not write to is refused in one line") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const fs::path out = folder.path() / "out";
    for (const Command& command : commands(scene, out)) {
        if (command.new_folder) continue;
        fs::create_directory(out);
        CAPTURE(command.words);
        REQUIRE(run_program(with_seed(command, "1")).status == 0);
        const FolderContents earlier = contents_of(out);
        for (const auto& [name, content] : earlier) {
            if (name.ends_with('/')) continue;
            CAPTURE(name);
            fs::permissions(out / name, fs::perms(0444));
            const ProgramResult result = run_program(with_seed(command, "2"));
            CHECK(result.status == 2);
            CHECK(result.err ==
                  "aula: " + (out / name).string() +
                      ": is write-protected (mode 0444) and would be replaced; expected write "
                      "permission for its owner (chmod u+w)\n");
            CHECK(contents_of(out) == earlier);
            fs::permissions(out / name, fs::perms(0644));
        }
        fs::remove_all(out);
    }
}

TEST_CASE("a disk without a free byte is named as the reason, for all kinds of files") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const fs::path disk = folder.path() / "disk";
    fs::create_directory(disk);
    // A file system in memory, which only this process and its children see.
    const auto on_full_disk = [&](const Command& command) {
        std::vector<std::string> words{"unshare",
                                       "-rm",
                                       "sh",
                                       "-c",
                                       "mount -t tmpfs -o size=64k full \"$0\" || exit 77; "
                                       "dd if=/dev/zero of=\"$0/rest\" bs=4096 2>/dev/null; "
                                       "\"$@\"; status=$?; ls -A \"$0\"; exit $status",
                                       disk};
        const std::vector<std::string> program = with_seed(command, "1");
        words.insert(words.end(), program.begin(), program.end());
        words.emplace_back("--quiet");  // no lines of progress
        return run_program(words);
    };
    for (const Command& command : commands(scene, disk)) {
        CAPTURE(command.words);
        const ProgramResult result = on_full_disk(command);
        if (result.status == 77 || result.err.find("unshare") == 0) {
            WARN("skipped: no file system can be mounted");
            return;
        }
        INFO(result.err);
        CHECK((result.status == 1 || result.status == 2));
        CHECK_THAT(result.err, Contains("No space left on device"));
        CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
        CHECK(result.out == "rest\n");
    }
}

TEST_CASE("the files of a measurement are written before the table is printed") {
    const TemporaryFolder folder;
    const std::string scene = folder.write("room.json", kSmallRoom);
    const fs::path file = folder.path() / "e.csv";
    const auto measure = [&](const std::string& reader) {
        fs::remove(file);
        return run_program(
            {"bash", "-c",
             "set -o pipefail; \"$0\" \"$1\" --frames 1 --report --echogram \"$2\" " + reader,
             AULA_PROGRAM, scene, file});
    };
    CHECK(measure(">/dev/null").status == 0);
    const std::string rows = read_file(file);
    CHECK_FALSE(rows.empty());
    const ProgramResult full = measure(">/dev/full");
    CHECK(full.status == 1);
    CHECK_THAT(full.err, Contains("standard output: cannot write"));
    CHECK(read_file(file) == rows);
    // Status 141 if the reader has ended before the table is printed.
    const int status = measure("| true").status;
    CHECK((status == 141 || status == 0));
    CHECK(read_file(file) == rows);
}
