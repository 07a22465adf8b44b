#pragma once

#include "apps/output/output_file.h"

namespace aula {

/// Writes the lower left part of the current framebuffer to a PNG file and commits it. Size in
/// pixels. Throws Failure.
void write_screenshot(OutputFile& file, int width, int height);

}  // namespace aula
