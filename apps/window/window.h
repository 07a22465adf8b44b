#pragma once

#include "apps/session/live/player.h"
#include "apps/window/model/window_options.h"

namespace aula {

/// Whether a window can be opened here.
bool window_possible();

/// Plays a scene in a window until that is closed, the time that was asked for is over, or a
/// screenshot has been written; how that went. Throws Error, AudioInputError, AudioFailure.
PlayStatus show_window(const WindowOptions& options);

}  // namespace aula
