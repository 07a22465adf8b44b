#include "apps/window/screenshot.h"

#include <GL/glew.h>
#include <stb/stb_image_write.h>

#include <vector>

#include "engine/error.h"

namespace aula {

void write_screenshot(const std::filesystem::path& file, int width, int height) {
    constexpr int kChannels = 3;
    const int row_bytes = kChannels * width;
    std::vector<unsigned char> pixels(static_cast<std::size_t>(row_bytes) *
                                      static_cast<std::size_t>(height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    // OpenGL's rows go up, those of a picture down.
    std::vector<unsigned char> rows;
    rows.reserve(pixels.size());
    for (int y = height; y-- > 0;) {
        const auto row = pixels.begin() + static_cast<std::ptrdiff_t>(y) * row_bytes;
        rows.insert(rows.end(), row, row + row_bytes);
    }
    if (stbi_write_png(file.c_str(), width, height, kChannels, rows.data(), row_bytes) == 0)
        throw Error(file.string() + ": cannot write; expected a place for a PNG file");
}

}  // namespace aula
