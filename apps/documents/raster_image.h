#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/documents/value_scale.h"

namespace aula {

/// A PNG file of pixels in red, green and blue, [row][column][RGB], by rows from above.
std::string png_file(int width, int height, std::span<const std::uint8_t> pixels);

/// The folder of the font of documents and the window, DejaVu Sans.
inline const std::filesystem::path kFontFolder = "/usr/share/fonts/truetype/dejavu";

/// A picture that is drawn by the processor. Positions are in pixels from the upper left corner;
/// what lies outside is cut off.
class RasterImage {
 public:
    /// White. Without the font file, a built-in font for ASCII writes all texts.
    RasterImage(int width, int height, const std::filesystem::path& font);
    ~RasterImage();
    RasterImage(const RasterImage&) = delete;
    RasterImage& operator=(const RasterImage&) = delete;

    int width() const { return width_; }
    int height() const { return height_; }

    void fill(glm::vec2 from, glm::vec2 to, const Colour& colour);
    void line(glm::vec2 from, glm::vec2 to, float width, const Colour& colour);
    void disc(glm::vec2 centre, float radius, const Colour& colour);

    /// Writes UTF-8. `at` is the left end of the base line; `height` is that of the font.
    void text(glm::vec2 at, const std::string& text, float height, const Colour& colour);
    float text_width(const std::string& text, float height) const;

    /// The picture as a PNG file.
    std::string png() const { return png_file(width_, height_, pixels_); }

 private:
    struct Font;

    void blend(int x, int y, float share, const Colour& colour);

    int width_;
    int height_;
    std::vector<std::uint8_t> pixels_;  ///< [row][column][RGB]
    std::unique_ptr<Font> font_;
};

}  // namespace aula
