#pragma once

#include <filesystem>

namespace aula {

/// Writes the lower left part of the framebuffer that is drawn to, of a size in pixels, to a PNG
/// file. Throws Error.
void write_screenshot(const std::filesystem::path& file, int width, int height);

}  // namespace aula
