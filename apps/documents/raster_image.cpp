#include "apps/documents/raster_image.h"

#include <stb/stb_easy_font.h>
#include <stb/stb_image_write.h>
#include <stb/stb_truetype.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>

namespace aula {

namespace {

constexpr std::size_t kChannels = 3;

/// The height of the capital letters of the built-in font in its units.
constexpr float kBuiltInHeight = 10;

/// The Unicode code points of UTF-8; invalid bytes become U+FFFD.
std::vector<int> code_points(const std::string& text) {
    std::vector<int> points;
    for (std::size_t i = 0; i < text.size();) {
        const auto byte = [&](std::size_t at) {
            return at < text.size() ? static_cast<unsigned char>(text[at]) : 0U;
        };
        const unsigned first = byte(i);
        const std::size_t length = first < 0x80       ? 1
                                   : first >> 5 == 6  ? 2
                                   : first >> 4 == 14 ? 3
                                   : first >> 3 == 30 ? 4
                                                      : 0;
        unsigned point = length == 1 ? first : first & (0x7FU >> length);
        bool valid = length > 0;
        for (std::size_t k = 1; k < length; ++k) {
            valid = valid && byte(i + k) >> 6 == 2;
            point = point << 6 | (byte(i + k) & 0x3F);
        }
        points.push_back(valid ? static_cast<int>(point) : 0xFFFD);
        i += valid ? length : 1;
    }
    return points;
}

}  // namespace

std::string png_file(int width, int height, std::span<const std::uint8_t> pixels) {
    const auto write = [](void* to, void* data, int size) {
        static_cast<std::string*>(to)->append(static_cast<const char*>(data),
                                              static_cast<std::size_t>(size));
    };
    std::string png;
    const int channels = static_cast<int>(kChannels);
    stbi_write_png_to_func(write, &png, width, height, channels, pixels.data(), channels * width);
    return png;
}

/// A TrueType font, or the built-in one if its file is missing.
struct RasterImage::Font {
    std::vector<unsigned char> file;
    stbtt_fontinfo info{};
    bool is_file = false;

    explicit Font(const std::filesystem::path& name) {
        std::ifstream in(name, std::ios::binary);
        file.assign(std::istreambuf_iterator<char>(in), {});
        is_file = !file.empty() && stbtt_InitFont(&info, file.data(), 0) != 0;
    }
};

RasterImage::RasterImage(int width, int height, const std::filesystem::path& font)
    : width_(width),
      height_(height),
      pixels_(kChannels * static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255),
      font_(std::make_unique<Font>(font)) {}

RasterImage::~RasterImage() = default;

void RasterImage::blend(int x, int y, float share, const Colour& colour) {
    if (x < 0 || y < 0 || x >= width_ || y >= height_ || share <= 0) return;
    const auto first = kChannels * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                    static_cast<std::size_t>(x));
    for (std::size_t c = 0; c < kChannels; ++c) {
        std::uint8_t& value = pixels_[first + c];
        const float wanted = 255 * colour[static_cast<int>(c)];
        value = static_cast<std::uint8_t>(
            std::lround(glm::mix(static_cast<float>(value), wanted, std::min(share, 1.0F))));
    }
}

void RasterImage::fill(glm::vec2 from, glm::vec2 to, const Colour& colour) {
    const glm::ivec2 first = glm::round(from);
    const glm::ivec2 end = glm::round(to);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) blend(x, y, 1, colour);
}

void RasterImage::line(glm::vec2 from, glm::vec2 to, float width, const Colour& colour) {
    const float reach = width / 2 + 1;
    const glm::ivec2 first = glm::floor(glm::min(from, to) - reach);
    const glm::ivec2 last = glm::ceil(glm::max(from, to) + reach);
    const glm::vec2 along = to - from;
    const float square = std::max(glm::dot(along, along), 1e-6F);
    for (int y = std::max(first.y, 0); y <= std::min(last.y, height_ - 1); ++y)
        for (int x = std::max(first.x, 0); x <= std::min(last.x, width_ - 1); ++x) {
            const glm::vec2 pixel = glm::vec2(x, y) + 0.5F;
            const float share = std::clamp(glm::dot(pixel - from, along) / square, 0.0F, 1.0F);
            blend(x, y, width / 2 + 0.5F - glm::distance(pixel, from + share * along), colour);
        }
}

void RasterImage::disc(glm::vec2 centre, float radius, const Colour& colour) {
    line(centre, centre, 2 * radius, colour);
}

void RasterImage::text(glm::vec2 at, const std::string& text, float height, const Colour& colour) {
    if (!font_->is_file) {
        // Each letter consists of quads of four corners (x, y, z, colour).
        struct Corner {
            float x, y, z;
            std::array<unsigned char, 4> colour;
        };
        std::string letters = text;
        for (char& c : letters)
            if (c < ' ' || c > '~') c = '?';
        std::vector<Corner> corners(64 * (letters.size() + 1));
        const int quads = stb_easy_font_print(0, 0, letters.data(), nullptr, corners.data(),
                                              static_cast<int>(sizeof(Corner) * corners.size()));
        const float scale = height / kBuiltInHeight;
        const glm::vec2 top = at - glm::vec2(0, 0.7F * height);
        for (std::size_t q = 0; q < static_cast<std::size_t>(quads); ++q) {
            const Corner& low = corners[4 * q];
            const Corner& high = corners[4 * q + 2];
            fill(top + scale * glm::vec2(low.x, low.y), top + scale * glm::vec2(high.x, high.y),
                 colour);
        }
        return;
    }
    const float scale = stbtt_ScaleForPixelHeight(&font_->info, height);
    for (const int point : code_points(text)) {
        int width = 0;
        int rows = 0;
        int left = 0;
        int top = 0;
        const float shift = at.x - std::floor(at.x);
        unsigned char* const glyph = stbtt_GetCodepointBitmapSubpixel(
            &font_->info, scale, scale, shift, 0, point, &width, &rows, &left, &top);
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < width; ++x)
                blend(static_cast<int>(std::floor(at.x)) + left + x,
                      static_cast<int>(std::lround(at.y)) + top + y,
                      static_cast<float>(glyph[y * width + x]) / 255, colour);
        stbtt_FreeBitmap(glyph, nullptr);
        int advance = 0;
        stbtt_GetCodepointHMetrics(&font_->info, point, &advance, nullptr);
        at.x += scale * static_cast<float>(advance);
    }
}

float RasterImage::text_width(const std::string& text, float height) const {
    if (!font_->is_file) {
        std::string letters = text;
        return static_cast<float>(stb_easy_font_width(letters.data())) * height / kBuiltInHeight;
    }
    const float scale = stbtt_ScaleForPixelHeight(&font_->info, height);
    float width = 0;
    for (const int point : code_points(text)) {
        int advance = 0;
        stbtt_GetCodepointHMetrics(&font_->info, point, &advance, nullptr);
        width += scale * static_cast<float>(advance);
    }
    return width;
}

}  // namespace aula
