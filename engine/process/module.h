#pragma once

namespace aula {

/// Prepares a library that programs of others load, at its entry points, before its other
/// functions. On Windows, which searches libraries in the folder of the program, loads those that
/// it needs from its own folder, and keeps it in memory, because its threads may run when it is
/// unloaded: aula_module() defines it there. Elsewhere the linker does both. Returns false if a
/// library is missing. [any thread but that of the audio]
#if defined(_WIN32)
bool prepare_module() noexcept;
#else
inline bool prepare_module() noexcept { return true; }
#endif

}  // namespace aula
