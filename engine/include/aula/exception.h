#pragma once

#include <stdexcept>
#include <string>

/// Room acoustics in real time: propagation, impulse responses and rendering.
namespace aula {

/// The root of all exceptions of Aula. `what()` is one line for the user.
class Exception : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Bad input: a file, a device name, an option or a value that cannot be used. The text says what
/// is wrong and, after a semicolon, what was expected. Aula's programs exit with status 2.
class InputError : public Exception {
 public:
    using Exception::Exception;

    /// An error in a file. The text is "FILE: PLACE: PROBLEM". `place` is a JSON pointer such as
    /// "/sources/0/position", or line and column; an empty `place` is omitted.
    InputError(const std::string& file, const std::string& place, const std::string& problem)
        : Exception(file + ": " + (place.empty() ? "" : place + ": ") + problem) {}
};

/// A failure at run time: no device, device lost, disk full. Aula's programs exit with status 1.
class Failure : public Exception {
 public:
    using Exception::Exception;
};

}  // namespace aula
