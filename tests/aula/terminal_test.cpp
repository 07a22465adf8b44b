#include "apps/aula/terminal.h"

#include <catch2/catch.hpp>

using aula::printable;

TEST_CASE("Names cannot change the terminal that they are printed on") {
    CHECK(printable("hall \x1b[31mred\x07") == "hall \\x1b[31mred\\x07");
    CHECK(printable("a\rb\tc\x7f") == "a\\x0db\\x09c\\x7f");
    // The control sequence introducer as one byte, and as U+009B.
    CHECK(printable("\x9b"
                    "31m") == "\\x9b31m");
    CHECK(printable("\xc2\x9b"
                    "31m") == "\\xc2\\x9b31m");
    CHECK(printable("cut \xe2\x82") == "cut \\xe2\\x82");
    CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
    // Other text, and the line ends of tables, stay as they are.
    const std::string text = "Größe 5 m² → 漢字 🎵\nnext";
    CHECK(printable(text) == text);
}
