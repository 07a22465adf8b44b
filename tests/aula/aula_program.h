#pragma once

#include <catch2/catch.hpp>
#include <string>
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

}  // namespace aula::test
