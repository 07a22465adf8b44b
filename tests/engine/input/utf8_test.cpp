#include "engine/input/utf8.h"

#include <catch2/catch.hpp>
#include <string>

using namespace aula;

TEST_CASE("Text that is UTF-8 stays, other text is Latin-1") {
    for (const std::string text : {"", "Wand", "Wände", "\u2026\U0001F50A"})
        CHECK(utf8_of(text) == text);
    CHECK(utf8_of("W\xe4nde") == "Wände");
    CHECK(utf8_of("\xff\xfe") == "ÿþ");
    // A surrogate, an overlong form, and a character that ends too soon.
    for (const std::string text : {"\xed\xa0\x80", "\xc0\xaf", "a\xe2\x80"}) {
        CHECK(utf8_of(text) != text);
        CHECK(utf8_of(utf8_of(text)) == utf8_of(text));
    }
}
