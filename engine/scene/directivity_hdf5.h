#pragma once

#include <functional>

#include "engine/scene/directivity_answer.h"

namespace aula {

/// Reads a SOFA file of directivities (FreeFieldDirectivityTF) with HDF5, which can crash, loop and
/// allocate gigabytes on malformed files: only in a ContainedProcess. `opened` is called when the
/// file is open; it forbids the process to open others, which the file may name.
DirectivityAnswer read_hdf5_directivity(const char* file, const std::function<void()>& opened);

}  // namespace aula
