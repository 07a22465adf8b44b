#pragma once

#include "process/contained_process.h"

namespace aula {

/// The executable file built from directivity_reader.cpp. Throws InputError, without the name of a
/// file, if Aula was built without HDF5.
ContainedProgram embedded_directivity_reader();

}  // namespace aula
