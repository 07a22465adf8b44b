#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/program.h"

namespace aula::test {

/// Runs aula to its end.
inline ProgramResult aula_with(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), AULA_PROGRAM);
    return run_program(arguments);
}

/// A scene with one part of its text replaced.
inline std::string with(std::string scene, const std::string& from, const std::string& to) {
    const std::size_t at = scene.find(from);
    REQUIRE(at != std::string::npos);
    return scene.replace(at, from.size(), to);
}

/// Requires that the program prints one line that begins with "aula: " and contains all `parts`,
/// exits with 2 and leaves the folder unchanged.
inline void require_refused(const TemporaryFolder& folder, std::vector<std::string> arguments,
                            const std::vector<std::string>& parts) {
    const auto before = names_in(folder.path());
    const ProgramResult result = aula_with(std::move(arguments));
    INFO("standard error: " << result.err);
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK(result.err.rfind("aula: ", 0) == 0);
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(result.err.find("expected") != std::string::npos);
    for (const std::string& part : parts) {
        INFO("expected part: " << part);
        CHECK(result.err.find(part) != std::string::npos);
    }
    CHECK(names_in(folder.path()) == before);
}

/// Arguments that are refused, and parts of the message.
struct Refused {
    std::vector<std::string> arguments;
    std::vector<std::string> parts;
};

}  // namespace aula::test
