#pragma once

#include <cstddef>
#include <string>

#include "tests/support/temporary_folder.h"

namespace aula::test {

/// Writes room.json, a scene with the sources "voice" and "radio", and their sounds a.wav and
/// b.wav.
void write_two_sounds(const TemporaryFolder& folder);

/// Moves the voice to (1, 1.5, 1.25) and the listener to (3, 2, 1.5) with a yaw of 45 degrees, and
/// sets the gain of the radio to -20 dB in room.json.
void write_moved_sounds(const TemporaryFolder& folder);

/// The largest difference of half a second of out.wav, which a host has recorded, and the first
/// channels of `aula --offline` of room.json with this output (--output).
float difference_from_offline(const TemporaryFolder& folder, std::size_t recorded_channels,
                              const std::string& output = "binaural");

}  // namespace aula::test
