#pragma once

namespace aula {

/// Load libjack and libasound of the system, at the first call. Return the library as dlopen(), or
/// null if there is none: then none of its functions may be called. [any thread]
void* load_jack();
void* load_alsa();

/// Loads libjack and turns off its messages. False if there is none.
bool load_silent_jack();

}  // namespace aula
