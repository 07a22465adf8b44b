#pragma once

#include <cstddef>
#include <span>

#include "engine/scene/directivity_answer.h"

namespace aula {

/// Reads a SOFA file of directivities (FreeFieldDirectivityTF) with HDF5, which can crash, loop and
/// allocate gigabytes on malformed files: only in a ContainedProcess, which prevents it from
/// opening the other files that a file may name.
DirectivityAnswer read_hdf5_directivity(std::span<const std::byte> file);

}  // namespace aula
