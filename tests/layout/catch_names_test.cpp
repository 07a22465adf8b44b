#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

TEST_CASE("tests use only names of Catch2 2 that support/catch2_3 gives to Catch2 3") {
    namespace fs = std::filesystem;
    const fs::path tests = fs::path(AULA_SOURCE_DIR) / "tests";
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(tests)) {
        const fs::path& file = entry.path();
        if (file.extension() != ".cpp" || file.filename() == "catch_names_test.cpp") continue;
        ++count;
        CAPTURE(file);
        std::ifstream in(file);
        const std::string text(std::istreambuf_iterator<char>(in), {});
        CHECK(text.find("Catch::Matchers") == std::string::npos);  // Catch::Contains
        CHECK(text.find("<catch2/catch_") == std::string::npos);   // <catch2/catch.hpp>
        // CTest reads a name with a semicolon as two names.
        static const std::regex with_semicolon("TEST_CASE\\(\\s*\"[^\"\\n]*;");
        CHECK_FALSE(std::regex_search(text, with_semicolon));
    }
    CHECK(count > 200);
}
