#pragma once

#include <string>

namespace aula::test {

/// Free field with a source 3.432 m, or 10 ms, in front of the listener.
inline const std::string kFreeField = R"({
  "aula": 1,
  "medium": {"air_absorption": false},
  "sources": [{"name": "click", "position": [3.432, 0, 0], "signal": "impulse"}],
  "listener": {"position": [0, 0, 0]}
})";

/// A small room, for rays alone, with a source of noise and a listener path of one second.
inline const std::string kSmallRoom = R"({
  "aula": 1,
  "geometry": [{"box": [5, 4, 3], "material": "wall"}],
  "materials": {"wall": {"absorption": 0.3, "scattering": 0.5}},
  "sources": [{"name": "hiss", "position": [1.2, 1.1, 1.5], "signal": "noise", "gain_db": -6}],
  "listener": {"position": [3.7, 2.9, 1.2], "path": {"points": [
    {"t": 0, "position": [3.7, 2.9, 1.2], "yaw_deg": 180},
    {"t": 1, "position": [2.5, 2.9, 1.2], "yaw_deg": 120}]}},
  "simulation": {"rays": 200, "ir_length_s": 0.5, "waves": false}
})";

}  // namespace aula::test
