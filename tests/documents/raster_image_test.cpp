#include "apps/documents/raster_image.h"

#include <catch2/catch.hpp>
#include <string>

namespace {

using namespace aula;

/// Width or height in the header of a PNG file.
int header_number(const std::string& png, std::size_t at) {
    int value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = 256 * value + static_cast<unsigned char>(png.at(at + i));
    return value;
}

}  // namespace

TEST_CASE("A picture is a PNG file of its size") {
    RasterImage image(40, 30, {});
    const std::string png = image.png();
    REQUIRE(png.starts_with("\x89PNG\r\n"));
    CHECK(header_number(png, 16) == 40);
    CHECK(header_number(png, 20) == 30);
}

TEST_CASE("Shapes that are partly or fully outside of a picture are cut off") {
    RasterImage image(40, 30, {});
    const std::string empty = image.png();
    image.line({-50, -20}, {-10, -5}, 3, {0, 0, 0});
    image.fill({60, 10}, {80, 20}, {0, 0, 0});
    CHECK(image.png() == empty);
    image.disc({0, 0}, 5, {0, 0, 0});
    CHECK(image.png() != empty);
    image.text({30, 40}, "outside", 20, {0, 0, 0});
}

TEST_CASE("Text is written with the font file and without it, also what is not UTF-8") {
    for (const std::filesystem::path& font :
         {kFontFolder / "DejaVuSans.ttf", std::filesystem::path("/none.ttf")}) {
        RasterImage image(200, 40, font);
        const std::string empty = image.png();
        CHECK(image.text_width("T30 in s", 18) > 40);
        CHECK(image.text_width("T30 in s", 18) < 120);
        CHECK(image.text_width("", 18) == 0);
        for (const char* const text : {"T30", "Bühne", "\xff\xc3", "日本"}) {
            RasterImage written(200, 40, font);
            written.text({10, 30}, text, 18, {0, 0, 0});
            CHECK(written.png() != empty);
        }
    }
}
