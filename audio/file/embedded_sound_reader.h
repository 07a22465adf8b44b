#pragma once

#include "process/contained_process.h"

namespace aula {

/// The executable file built from sound_reader.cpp.
ContainedProgram embedded_sound_reader();

}  // namespace aula
