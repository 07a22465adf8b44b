#pragma once

#include <filesystem>

#include "apps/aula/arguments.h"

namespace aula {

/// The file of a source's impulse response: of several sources OUT-NAME.wav, where characters
/// outside [A-Za-z0-9._-] become '_'.
std::filesystem::path response_file(const std::filesystem::path& file, const Scene& scene,
                                    std::size_t source);

/// Throws Error if a file that is to be written is one that is read, or is to be written twice,
/// by whatever name or link.
void check_outputs(const Arguments& arguments, const Scene& scene);

}  // namespace aula
