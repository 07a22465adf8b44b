#pragma once

namespace aula::test {

/// The tone that a watched plugin gets.
inline constexpr double kTone_hz = 20;
inline constexpr float kTone_amplitude = 0.25F;

/// The calls of run() of a watched plugin.
struct WatchedCalls {
    long count = 0;
    long late = 0;         ///< calls with more processor time than the block lasts
    long waits = 0;        ///< of the calling thread, inside, but for those at page faults
    long page_faults = 0;  ///< of the calling thread, inside
    long moves = 0;        ///< calls at which the source had a new x
    double total_s = 0;    ///< processor time of the calling thread
    double longest_s = 0;  ///< that of the longest call
};

}  // namespace aula::test
