#pragma once

#include <stdexcept>
#include <string>

namespace aula {

/// Bad input: a file, an option or a value that cannot be used. `what()` is one line for the user,
/// "FILE: PLACE: what is wrong; what was expected". PLACE is a JSON pointer, line and column for a
/// syntax error, or omitted. Programs exit with 2.
class Error : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;

    Error(const std::string& file, const std::string& place, const std::string& problem)
        : std::runtime_error(file + ": " + (place.empty() ? "" : place + ": ") + problem) {}
};

}  // namespace aula
