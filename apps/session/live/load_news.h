#pragma once

#include <optional>
#include <string>

#include "apps/session/live/player.h"

namespace aula {

/// "..." in words where a player takes fewer rays, or a shorter response, than its scene would
/// have; else empty.
std::string reduction_text(const PlayStatus& status);

/// Says once that a player takes less, when it has found how much, and again when it shortens the
/// response further. [one thread]
class LoadNews {
 public:
    /// The news of now, if there are any; `now_s` is any clock's time.
    std::optional<std::string> take(const PlayStatus& status, double now_s);

 private:
    std::optional<double> length_s_;  ///< at which it was first seen to take less
    double since_s_ = 0;
    bool reported_ = false;
};

}  // namespace aula
