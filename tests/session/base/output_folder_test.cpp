#include "apps/session/base/output_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "aula/exception.h"
#include "tests/support/program.h"

namespace {

using namespace aula;
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
    fs::create_directory(folder.path() / ".out.old");
    write(folder.path() / ".out.old/file", "earlier");
    fs::create_directory(folder.path() / ".out.part");
    write(folder.path() / ".out.part/file", "unfinished");
    { const OutputFolder written(folder.path() / "out"); }
    CHECK(names_in(folder.path()) == Names{"out"});
    CHECK(read_file(folder.path() / "out/file") == "earlier");

    fs::create_directory(folder.path() / ".out.old");
    { const OutputFolder written(folder.path() / "out"); }
    CHECK(names_in(folder.path()) == Names{"out"});
    CHECK(read_file(folder.path() / "out/file") == "earlier");
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
    CHECK(names_in(folder.path()) == Names{".out.part", "file"});
}
