#pragma once

#include <string>

#include "apps/documents/report/room_report.h"

namespace aula {

/// A plan, positions and distances of sources and receivers.
std::string positions_section(const RoomReport& report);

/// The settings of the propagation, the air, the room, and the levels of speech and noise.
std::string conditions_section(const RoomReport& report);

/// The materials with their areas and the sources of their coefficients, the layers of mesh files,
/// and what was guessed of a model.
std::string materials_section(const RoomReport& report);

/// Levels of speech in dB(A) and STI with class and rating of all audible pairs, and ISO 3382-3 for
/// talkers with a line of receivers.
std::string speech_section(const RoomReport& report);

/// Measured values beside the simulated ones, in octaves and with their differences in just
/// noticeable ones: those of each response that has the name of a receiver (with one source) or of
/// a pair, "SOURCE at RECEIVER"; the mean of all others beside the mean of all audible pairs. Empty
/// without measured values.
std::string measured_section(const RoomReport& report);

}  // namespace aula
