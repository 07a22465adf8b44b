#pragma once

#include "process/contained_process.h"

namespace aula {

/// The executable file built from sofa_reader.cpp.
ContainedProgram embedded_sofa_reader();

}  // namespace aula
