#include "apps/window/screenshot.h"

#include <epoxy/gl.h>

#include <cstddef>
#include <vector>

#include "apps/documents/raster_image.h"

namespace aula {

void write_screenshot(OutputFile& file, int width, int height) {
    constexpr int kChannels = 3;
    const int row_bytes = kChannels * width;
    std::vector<unsigned char> pixels(static_cast<std::size_t>(row_bytes) *
                                      static_cast<std::size_t>(height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    // OpenGL's rows run upwards, those of PNG downwards.
    std::vector<unsigned char> rows;
    rows.reserve(pixels.size());
    for (int y = height; y-- > 0;) {
        const auto row = pixels.begin() + static_cast<std::ptrdiff_t>(y) * row_bytes;
        rows.insert(rows.end(), row, row + row_bytes);
    }
    file.write(png_file(width, height, rows));
    file.commit();
}

}  // namespace aula
