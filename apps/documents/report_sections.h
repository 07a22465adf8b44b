#pragma once

#include <string>

#include "apps/documents/room_report.h"

namespace aula {

/// Sections of a report on speech: levels in dB(A), STI with class and rating of all audible pairs,
/// and ISO 3382-3 for sources with enough receivers at 2 to 16 m.
std::string speech_section(const RoomReport& report);

/// Measured values beside the simulated ones, in octaves and with their differences in just
/// noticeable ones: those of each response that has the name of a receiver (with one source) or of
/// a pair, "SOURCE at RECEIVER"; the mean of all others beside the mean of all audible pairs. Empty
/// without measured values.
std::string measured_section(const RoomReport& report);

}  // namespace aula
