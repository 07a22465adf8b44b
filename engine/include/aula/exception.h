#pragma once

#include <stdexcept>
#include <string>

namespace aula {

/// The root of all exceptions of Aula. `what()` is one line for the user.
class Exception : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Bad input: a file, a device name, an option or a value that cannot be used. `what()` is
/// "FILE: PLACE: what is wrong; what was expected". PLACE is a JSON pointer, line and column for a
/// syntax error, or omitted. Programs exit with 2.
class InputError : public Exception {
 public:
    using Exception::Exception;

    InputError(const std::string& file, const std::string& place, const std::string& problem)
        : Exception(file + ": " + (place.empty() ? "" : place + ": ") + problem) {}
};

/// A failure at run time: no device, device lost, disk full. Programs exit with 1.
class Failure : public Exception {
 public:
    using Exception::Exception;
};

}  // namespace aula
