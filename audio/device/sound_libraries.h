#pragma once

namespace aula {

/// Load libjack and libasound of the system, at the first call. Return the library as dlopen(), or
/// null if there is none: then none of its functions may be called. [any thread]
void* load_jack();
void* load_alsa();

}  // namespace aula
