#pragma once

#include <cstddef>
#include <span>

namespace aula {

/// The executable file built from directivity_reader.cpp.
std::span<const std::byte> embedded_directivity_reader();

}  // namespace aula
