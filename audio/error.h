#pragma once

#include <stdexcept>

namespace aula {

/// A sound file, HRTF file or device that was asked for and cannot be used; programs exit with 2.
class AudioInputError : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// Failed while running: no device at all, a device lost, a disk full; programs exit with 1.
class AudioFailure : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

}  // namespace aula
