#pragma once

#include "apps/session/base/output_file.h"

namespace aula {

/// Writes the lower left part of the framebuffer that is drawn to, of a size in pixels, to a PNG
/// file, whole or not at all. Throws AudioFailure.
void write_screenshot(OutputFile& file, int width, int height);

}  // namespace aula
