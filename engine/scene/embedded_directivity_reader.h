#pragma once

#include "process/contained_process.h"

namespace aula {

/// The executable file built from directivity_reader.cpp.
ContainedProgram embedded_directivity_reader();

}  // namespace aula
