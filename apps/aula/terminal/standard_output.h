#pragma once

#include "aula/exception.h"

namespace aula {

/// The reader of standard output has ended, as `head` does after its lines. No message is printed
/// for it.
class ReaderEnded : public Failure {
 public:
    ReaderEnded() : Failure("standard output: its reader has ended") {}
};

/// Exit status for it: 128 + SIGPIPE.
inline constexpr int kReaderEndedStatus = 141;

/// Writes what is buffered for standard output. Throws ReaderEnded, or Failure as on a full disk.
void flush_standard_output();

}  // namespace aula
