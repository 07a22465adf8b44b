#include "audio/file/part_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace {

using namespace aula;
using test::names_in;
using test::read_file;
using test::TemporaryFolder;

void write_part(const std::filesystem::path& file, const std::string& text) {
    PartFile part(file);
    REQUIRE(write(part.descriptor(), text.data(), text.size()) ==
            static_cast<ssize_t>(text.size()));
    part.commit();
}

mode_t permissions(const std::filesystem::path& file) {
    struct stat status {};
    REQUIRE(stat(file.c_str(), &status) == 0);
    return status.st_mode & 0777U;
}

}  // namespace

TEST_CASE("A replaced file keeps its permissions, a new one has the user's defaults") {
    const TemporaryFolder folder;
    const auto old_file = folder.write("old", "before");
    const mode_t mode = GENERATE(0600U, 0640U, 0666U);
    REQUIRE(chmod(old_file.c_str(), mode) == 0);
    write_part(old_file, "after");
    CHECK(read_file(old_file) == "after");
    CHECK(permissions(old_file) == mode);

    const mode_t before = umask(0027);
    write_part(folder.path() / "new", "new");
    umask(before);
    CHECK(permissions(folder.path() / "new") == 0640U);
    CHECK(names_in(folder.path()) == std::vector<std::string>{"new", "old"});
}

TEST_CASE("A symbolic link prepared at the name of a temporary file is not followed") {
    const TemporaryFolder folder;
    const auto victim = folder.write("victim", "mine");
    const auto target = folder.path() / "out";
    // Predictable names: one from the process id, and one without randomness.
    std::filesystem::create_symlink(victim,
                                    target.string() + "." + std::to_string(getpid()) + ".part");
    std::filesystem::create_symlink(victim, folder.path() / ".aula-0000000000000000.part");
    write_part(target, "new");
    CHECK(read_file(victim) == "mine");
    CHECK(read_file(target) == "new");
    CHECK_FALSE(std::filesystem::is_symlink(target));
}

TEST_CASE("The target of a symbolic link is replaced, not the link") {
    const TemporaryFolder folder;
    const auto file = folder.write("file", "before");
    std::filesystem::create_symlink("file", folder.path() / "link");
    write_part(folder.path() / "link", "after");
    CHECK(std::filesystem::is_symlink(folder.path() / "link"));
    CHECK(read_file(file) == "after");
}

TEST_CASE("A file with the longest possible name can be written twice at the same time") {
    const TemporaryFolder folder;
    const auto file = folder.path() / std::string(255, 'n');
    {
        const PartFile first(file);
        write_part(file, "second");
        CHECK(names_in(folder.path()).size() == 2);
    }
    CHECK(read_file(file) == "second");
    CHECK(names_in(folder.path()).size() == 1);
}
