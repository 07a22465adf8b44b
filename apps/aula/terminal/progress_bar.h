#pragma once

#include <chrono>
#include <string>

#include "apps/aula/terminal/terminal.h"

namespace aula {

/// A progress bar on standard error, drawn ten times a second.
class ProgressBar {
 public:
    ProgressBar(const std::string& what, bool quiet);

    /// Shows the completed share, 0..1. Returns false after a signal.
    bool operator()(double done);

 private:
    std::string what_;
    StatusLine line_;
    std::chrono::steady_clock::time_point next_;
};

}  // namespace aula
