#pragma once

#include "apps/room/live/player.h"
#include "apps/window/model/window_options.h"

namespace aula {

/// True if a window with OpenGL 3.3 can be opened.
bool window_possible();

/// Plays a scene in a window until the window is closed, the duration of playback is over or the
/// screenshot is written. Returns the last status. Throws InputError, Failure.
PlayStatus show_window(const WindowOptions& options);

}  // namespace aula
