#include "engine/model/material_search.h"

#include <algorithm>
#include <catch2/catch.hpp>

using namespace aula;

TEST_CASE("A search finds materials by words of their names and sources") {
    LibraryMaterial entry;
    entry.material.name = "oak_parquet";
    entry.source = "Vorländer 2008, parquet on counterfloor";
    const auto matches = [](const LibraryMaterial& of, const std::string& search) {
        return MaterialSearch(search).finds(of);
    };
    CHECK(matches(entry, ""));
    CHECK(matches(entry, "  "));
    CHECK(matches(entry, "oak"));
    CHECK(matches(entry, "OAK"));
    CHECK(matches(entry, "2008 oak"));
    CHECK(matches(entry, "counterfloor"));
    CHECK_FALSE(matches(entry, "oak glass"));
    CHECK_FALSE(matches(entry, "oakk"));
}

TEST_CASE("The shipped materials are narrowed by each word of a search") {
    const std::vector<LibraryMaterial> library = material_library();
    const auto found = [&](const std::string& search) {
        return std::count_if(library.begin(), library.end(),
                             [finder = MaterialSearch(search)](const LibraryMaterial& entry) {
                                 return finder.finds(entry);
                             });
    };
    CHECK(found("") == static_cast<std::ptrdiff_t>(library.size()));
    const std::ptrdiff_t glass = found("glass");
    CHECK(glass > 0);
    CHECK(glass < found(""));
    CHECK(found("glass 4") <= glass);
    CHECK(found("no such material") == 0);
    // By meaning.
    CHECK(found("Holz") >= 3);
    CHECK(found("schaum") > 0);
    CHECK(found("Teppich") >= 2);
}
