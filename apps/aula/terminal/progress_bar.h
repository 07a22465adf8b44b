#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "apps/aula/terminal/terminal.h"

namespace aula {

/// What shows progress if standard error is not a terminal: nothing, or lines for a log.
enum class ProgressLines { none, logged };

/// A progress bar on standard error, drawn ten times a second.
class ProgressBar {
 public:
    ProgressBar(const std::string& what, bool quiet, ProgressLines lines = ProgressLines::none);

    /// Shows the completed share, 0..1. Returns false after a signal.
    bool operator()(double done);

 private:
    std::string what_;
    StatusLine line_;
    std::chrono::steady_clock::time_point next_;
    std::optional<ProgressLog> log_;
};

}  // namespace aula
