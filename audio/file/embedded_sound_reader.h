#pragma once

#include <cstddef>
#include <span>

namespace aula {

/// The executable file built from sound_reader.cpp.
std::span<const std::byte> embedded_sound_reader();

}  // namespace aula
