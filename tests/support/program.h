#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace aula::test {

/// Names of the entries of a folder, sorted.
std::vector<std::string> names_in(const std::filesystem::path& folder);

std::string read_file(const std::filesystem::path& file);

/// Exit status and output of a program.
struct ProgramResult {
    int status = -1;  ///< exit status; 128 + signal if a signal ended it
    std::string out;
    std::string err;
    bool by_signal = false;
};

/// A program running with standard input from /dev/null and output to files.
class Program {
 public:
    explicit Program(const std::vector<std::string>& command);

    void signal(int number) const;
    bool running();
    std::string err() const;  ///< standard error so far
    ProgramResult wait();

 private:
    TemporaryFolder folder_;
    pid_t pid_ = -1;
    int wait_status_ = 0;
    bool ended_ = false;
};

/// Runs a program to its end.
ProgramResult run_program(const std::vector<std::string>& command);

/// Whether programs, separated by blanks, can be run.
bool are_installed(const std::string& programs);

}  // namespace aula::test
