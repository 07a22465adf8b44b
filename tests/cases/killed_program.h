#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace aula::test {

/// When a program is killed: before a call that changes files (tests/cases/kill_at_call.cpp).
struct Kill {
    enum class Calls { renaming, all } calls = Calls::renaming;
    bool exchanges = true;  ///< whether renameat2() can exchange names and keep one
};

/// Runs a program that is killed before its call `at`. Returns whether it was killed; requires
/// status 0 if it was not.
bool killed(const std::vector<std::string>& command, const Kill& kill, long at);

/// The number of the program's calls.
long calls_of(const std::vector<std::string>& command, const Kill& kill);

/// Names and contents of all files below a folder. Folders are names that end with '/'.
using FolderContents = std::map<std::string, std::string>;
FolderContents contents_of(const std::filesystem::path& folder);

/// Gives a folder these contents.
void restore(const std::filesystem::path& folder, const FolderContents& contents);

}  // namespace aula::test
