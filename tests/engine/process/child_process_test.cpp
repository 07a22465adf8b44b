#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "aula/exception.h"
#include "engine/process/contained_process.h"
#include "engine/process/files.h"
#include "tests/support/temporary_folder.h"

namespace child_process_test {

using Catch::Contains;

const std::string kName = "K\303\274che";  // Küche, in UTF-8

/// What the program of contained_answers.cpp answers.
std::vector<char> answer(const std::string& what, std::size_t size) {
    const std::filesystem::path program = AULA_CONTAINED_ANSWERS;
    aula::ContainedProcess process(program, what, aula::utf8_path(kName), "a file");
    std::vector<char> answered(size);
    process.read(answered);
    return answered;
}

TEST_CASE("a child process answers with what a file holds, under a name in UTF-8") {
    const aula::test::TemporaryFolder folder;
    const std::string text(200'000, 'x');  // more than a pipe holds
    const std::filesystem::path file = folder.path() / aula::utf8_path(kName);
    std::ofstream(file, std::ios::binary) << "answer " << text;
    aula::ContainedProcess process(std::filesystem::path(AULA_CONTAINED_ANSWERS), file, "a file");
    std::string read(2 * text.size(), '\0');
    process.read_bytes(read.data(), 10);
    process.read_bytes(read.data() + 10, read.size() - 10);
    CHECK(read == text + text);
    CHECK_THROWS_WITH(process.read_bytes(read.data(), 1),
                      Contains("ends before its answer is complete"));
}

TEST_CASE("a child process answers with bytes as they are") {
    const std::string bytes = "\r\n\x1a\n";
    const std::string expected = bytes + bytes;
    CHECK(answer("answer " + bytes, 8) == std::vector<char>(expected.begin(), expected.end()));
}

TEST_CASE("a child process that does not answer is an error that names the file") {
    CHECK_THROWS_WITH(answer("nothing", 1),
                      kName +
                          ": is damaged and cannot be read: the process that reads "
                          "it ends before its answer is complete; expected a file");
    CHECK_THROWS_WITH(answer("crash", 1), Contains("crashes"));
    CHECK_THROWS_WITH(answer("abort", 1), Contains("crashes"));
}

TEST_CASE("a child process may be ended before it has answered") {
    const aula::ContainedProcess computes(std::filesystem::path(AULA_CONTAINED_ANSWERS), "compute",
                                          "file", "a file");
    const aula::ContainedProcess answers(std::filesystem::path(AULA_CONTAINED_ANSWERS),
                                         "answer " + std::string(200'000, 'x'), "file", "a file");
    const std::filesystem::path none = "none";
    CHECK_THROWS_AS(aula::ContainedProcess(none, "answer", "file", "a file"), aula::Failure);
}

}  // namespace child_process_test
