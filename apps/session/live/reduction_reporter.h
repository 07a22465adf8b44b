#pragma once

#include <optional>
#include <string>

#include "apps/session/live/player.h"

namespace aula {

/// A description of the reduced rays or response length of a player; empty if neither is reduced.
std::string reduction_text(const PlayStatus& status);

/// Reports a reduction once when it is stable, and again when the response is shortened further.
/// [one thread]
class ReductionReporter {
 public:
    /// The present report, if there is one. `now_s` is the time of any clock.
    std::optional<std::string> take(const PlayStatus& status, double now_s);

 private:
    std::optional<double> length_s_;  ///< response length of the first reduction
    double since_s_ = 0;
    bool reported_ = false;
};

}  // namespace aula
