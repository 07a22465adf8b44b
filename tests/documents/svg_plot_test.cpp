#include "apps/documents/svg_plot.h"

#include <catch2/catch.hpp>

namespace {

using namespace aula;

std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++count;
    return count;
}

}  // namespace

TEST_CASE("Texts of HTML have no markup, no control characters and are UTF-8") {
    CHECK(html_text("<b>\"a\" & 'b'</b>") == "&lt;b&gt;&quot;a&quot; &amp; &#39;b&#39;&lt;/b&gt;");
    CHECK(html_text("Bühne 日本 \U0001F3B5") == "Bühne 日本 \U0001F3B5");
    CHECK(html_text("a\nb\x01\x7f") == "a b  ");
    // A byte that continues nothing, a cut character, an overlong form, a surrogate.
    const std::string unknown = "\xEF\xBF\xBD";
    CHECK(html_text("\x80") == unknown);
    CHECK(html_text("\xC3") == unknown);
    CHECK(html_text("\xC0\xAF") == unknown + unknown);
    CHECK(html_text("\xED\xA0\x80") == unknown + unknown + unknown);
}

TEST_CASE("A plot has its axes, its lines and a legend of the named ones") {
    SvgPlot plot({"time in s", 0, 2}, {"level in dB", -60, 0});
    plot.line({{0, 0}, {1, -30}, {2, -90}}, "#000000", "1 & 2");
    plot.line({{0, 0}, {2, 0}}, "#ff0000");
    plot.stem({1, -20}, "#00ff00", "stem");
    plot.stem({3, -20}, "#00ff00");  // outside
    const std::string svg = plot.svg();
    CHECK(count_of(svg, "<polyline") == 2);
    CHECK(count_of(svg, "1 &amp; 2") == 1);
    CHECK(count_of(svg, "stroke=\"#00ff00\"") == 2);  // the stem and its entry in the legend
    for (const char* const part : {"time in s", "level in dB", ">-60<", ">2.0<"})
        CHECK(count_of(svg, part) == 1);
    CHECK(count_of(svg, "<svg") == count_of(svg, "</svg>"));
}

TEST_CASE("An axis with names has one mark for each") {
    SvgPlot plot({"octave in Hz", -0.5, 2.5, {"63", "125", "250"}}, {"T30 in s", 0, 2});
    const std::string svg = plot.svg();
    for (const char* const name : {">63<", ">125<", ">250<"}) CHECK(count_of(svg, name) == 1);
    CHECK(count_of(svg, ">1.5<") == 1);
}

TEST_CASE("A plan contains its points, also without walls") {
    const std::string svg = plan_svg({}, {{{3, 4}, "a<b", true}, {{3, 4}, "seat", false}});
    CHECK(count_of(svg, "<circle") == 1);
    CHECK(count_of(svg, "a&lt;b") == 1);
    CHECK(svg.find("nan") == std::string::npos);
    CHECK(svg.find("inf") == std::string::npos);
}

TEST_CASE("Names in a plan avoid the marks and names beside them") {
    RoomSection plan;
    plan.walls = {{glm::vec2(0, 0), glm::vec2(12, 0)}, {glm::vec2(12, 0), glm::vec2(12, 9)}};
    plan.max = {12, 9};
    const auto place_of = [](const std::string& svg, const std::string& name) {
        const std::size_t end = svg.find(">" + name + "</text>");
        REQUIRE(end != std::string::npos);
        const std::size_t y = svg.rfind(" y=\"", end);
        return std::stod(svg.substr(y + 4));
    };
    // The second mark is 46 pixels to the right of the first, whose name has 41 from 9 on.
    const std::string svg =
        plan_svg(plan, {{{4, 2}, "desk 1", false}, {{4.9F, 2}, "desk 2", false}});
    CHECK(place_of(svg, "desk 1") == Approx(place_of(svg, "desk 2")));  // at the left of its mark
    CHECK(svg.find("text-anchor=\"end\">desk 1") != std::string::npos);
    // Marks on both sides: above.
    const std::string between = plan_svg(
        plan,
        {{{4, 2}, "desk 1", false}, {{4.9F, 2}, "desk 2", false}, {{3.2F, 2}, "desk 3", false}});
    CHECK(place_of(between, "desk 1") < place_of(between, "desk 2"));
}
