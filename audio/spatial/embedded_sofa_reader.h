#pragma once

#include <cstddef>
#include <span>

namespace aula {

/// The executable file built from sofa_reader.cpp.
std::span<const std::byte> embedded_sofa_reader();

}  // namespace aula
