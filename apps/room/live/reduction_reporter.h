#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "apps/room/live/player.h"

namespace aula {

/// A description of the reduced rays or response length of a player; empty if neither is reduced.
std::string reduction_text(const PlayStatus& status);

/// Reports a reduction once when it is stable, and again when the response is shortened further.
/// Frames that are late all the same, or because nothing may be reduced, are reported with what
/// takes less time. [one thread]
class ReductionReporter {
 public:
    /// `remedy` ends the report of a reduction: what sets rays and response length.
    explicit ReductionReporter(std::string remedy) : remedy_(std::move(remedy)) {}

    /// The present report, if there is one. `now_s` is the time of any clock.
    std::optional<std::string> take(const PlayStatus& status, double now_s);

 private:
    void count_from(const PlayStatus& status, double now_s);

    const std::string remedy_;
    std::optional<double> length_s_;  ///< of the response since `since_s_`
    bool reduced_ = false;            ///< since then
    double since_s_ = 0;
    double counted_since_s_ = 0;  ///< frames since then tell whether they are late
    std::uint64_t frames_ = 0;    ///< before it
    std::uint64_t late_ = 0;      ///< of them
    bool reported_ = false;
};

}  // namespace aula
