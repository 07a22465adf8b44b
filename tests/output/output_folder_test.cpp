#include "apps/output/output_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "aula/exception.h"
#include "tests/support/program.h"

namespace {

using namespace aula;
using Catch::Contains;
using test::names_in;
using test::read_file;
using test::TemporaryFolder;
using Names = std::vector<std::string>;
namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

}  // namespace

TEST_CASE("An output folder appears at its commit, in the place of an earlier one") {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    for (const std::string text : {"first", "second"}) {
        OutputFolder written(out / "");
        write(written.path("file"), text);
        CHECK(fs::exists(out) == (text == "second"));
        if (text == "second") CHECK(read_file(out / "file") == "first");
        written.commit();
        CHECK(read_file(out / "file") == text);
        CHECK(names_in(folder.path()) == Names{"out"});
    }
}

TEST_CASE("Without commit nothing remains of an output folder and of new folders above it") {
    const TemporaryFolder folder;
    {
        const OutputFolder written(folder.path() / "a/b/out");
        write(written.path("file"), "never");
    }
    CHECK(names_in(folder.path()).empty());
    {
        OutputFolder written(folder.path() / "a/b/out");
        written.commit();
    }
    CHECK(names_in(folder.path() / "a/b") == Names{"out"});
}

TEST_CASE("A folder that was renamed aside has its name again, or is removed if it was replaced") {
    const TemporaryFolder folder;
    fs::create_directory(folder.path() / ".aula-out.old");
    write(folder.path() / ".aula-out.old/file", "earlier");
    fs::create_directory(folder.path() / ".aula-out.part");
    write(folder.path() / ".aula-out.part/file", "unfinished");
    { const OutputFolder written(folder.path() / "out"); }
    CHECK(names_in(folder.path()) == Names{"out"});
    CHECK(read_file(folder.path() / "out/file") == "earlier");

    fs::create_directory(folder.path() / ".aula-out.old");
    { const OutputFolder written(folder.path() / "out"); }
    CHECK(names_in(folder.path()) == Names{"out"});
    CHECK(read_file(folder.path() / "out/file") == "earlier");
}

TEST_CASE("Hidden folders and files that Aula has not made stay") {
    const TemporaryFolder folder;
    for (const char* const name : {".out.old", ".out.part"})
        fs::create_directory(folder.path() / name);
    {
        OutputFolder written(folder.path() / "out");
        CHECK_FALSE(written.replaces());
        written.commit();
    }
    CHECK(names_in(folder.path()) == Names{".out.old", ".out.part", "out"});
    for (const std::string name : {".aula-new.old", ".aula-new.part"}) {
        folder.write(name, "mine");
        CHECK_THROWS_WITH(OutputFolder(folder.path() / "new"),
                          Contains(name + ": is not a folder; expected"));
        CHECK(read_file(folder.path() / name) == "mine");
        fs::remove(folder.path() / name);
    }
    CHECK(names_in(folder.path()) == Names{".out.old", ".out.part", "out"});
}

TEST_CASE(
    "A folder that another program creates before the commit stays, and so does the new one") {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    {
        OutputFolder written(out);
        write(written.path("file"), "mine");
        fs::create_directory(out);
        CHECK_THROWS_WITH(written.commit(), Contains("out: another program has created it") &&
                                                Contains(".aula-out.part"));
    }
    CHECK(names_in(out).empty());
    CHECK(read_file(folder.path() / ".aula-out.part/file") == "mine");
}

TEST_CASE("A folder has the permissions of the earlier one") {
    const TemporaryFolder folder;
    const fs::path out = folder.path() / "out";
    fs::create_directory(out);
    for (const unsigned mode : {02770U, 0700U, 0755U}) {
        fs::permissions(out, fs::perms(mode));
        OutputFolder written(out);
        written.commit();
        CHECK(fs::status(out).permissions() == fs::perms(mode));
    }
}

TEST_CASE("The name of an output folder may end with dots and slashes") {
    const TemporaryFolder folder;
    for (const char* const name : {"a/.", "b/./", "c//", "d/e/.."}) {
        CAPTURE(name);
        OutputFolder written(folder.path() / name);
        written.commit();
    }
    CHECK(names_in(folder.path()) == Names{"a", "b", "c", "d"});
}

TEST_CASE("A folder is written once at a time, and not below a file") {
    const TemporaryFolder folder;
    const OutputFolder written(folder.path() / "out");
    write(written.path("file"), "mine");
    CHECK_THROWS_AS(OutputFolder(folder.path() / "out"), InputError);
    CHECK(read_file(written.path("file")) == "mine");
    folder.write("file", "mine");
    CHECK_THROWS_AS(OutputFolder(folder.path() / "file/out"), InputError);
    CHECK_THROWS_AS(OutputFolder(folder.path() / "file/a/out"), InputError);
    CHECK(names_in(folder.path()) == Names{".aula-out.part", "file"});
}
