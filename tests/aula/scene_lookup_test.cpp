#include "apps/aula/scene_lookup.h"

#include <catch2/catch.hpp>

#include "aula/exception.h"
#include "tests/support/temporary_folder.h"

using namespace aula;
using namespace aula::test;

TEST_CASE("A scene's name without a slash is looked up in the folders, in their order") {
    const TemporaryFolder first;
    const TemporaryFolder second;
    const auto folders = {first.path(), second.path()};
    const auto both = first.write("both.json", "{}");
    second.write("both.json", "{}");
    const auto only = second.write("only.json", "{}");
    CHECK(find_scene("both", folders) == both);
    CHECK(find_scene("only", folders) == only);
    CHECK(find_scene("only.json", folders) == only);
    // With a slash the name is that of a file.
    CHECK(find_scene("./only", folders) == "./only");
    CHECK(find_scene("folder/only.json", folders) == "folder/only.json");
    try {
        find_scene("neither", folders);
        FAIL("there is no such scene");
    } catch (const InputError& error) {
        const std::string message = error.what();
        CHECK(message.starts_with("neither: "));
        CHECK(message.find(first.path()) != std::string::npos);
        CHECK(message.find(second.path()) != std::string::npos);
    }
}

TEST_CASE("A file of the working directory precedes the scenes that ship") {
    const TemporaryFolder folder;
    const auto here = std::filesystem::current_path();
    const TemporaryFolder working;
    working.write("name", "{}");
    std::filesystem::current_path(working.path());
    folder.write("name", "{}");
    const auto found = find_scene("name", {folder.path()});
    std::filesystem::current_path(here);
    CHECK(found == "name");
}
