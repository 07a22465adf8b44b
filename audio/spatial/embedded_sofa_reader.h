#pragma once

#include <cstddef>
#include <span>

namespace aula {

/// The program of sofa_reader.cpp, an executable file.
std::span<const std::byte> embedded_sofa_reader();

}  // namespace aula
