#pragma once

#include <string>
#include <vector>

namespace aula {

/// Sets up the process. Call it before any thread starts.
/// * SIGINT, SIGTERM and SIGHUP are recorded, so that the program can end in order. After 0.8 s, or
///   at a second signal, the process removes unfinished output files and exits with 128 + the
///   number of the first signal.
/// * SIGPIPE and SIGXFSZ are ignored: a write to a closed pipe or beyond the file size limit
/// returns
///   an error.
/// * Closed descriptors among 0 to 2 are opened, so that no output file takes their numbers.
void set_up_process();

/// The words of the command line, in UTF-8, of those that main() gets.
std::vector<std::string> command_line(int count, char** words);

/// Number of the first signal that has arrived, or 0. [any thread]
int interrupt_signal();

}  // namespace aula
