#pragma once

#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "apps/drawing/room_section.h"

namespace aula {

/// A text for HTML and SVG: special characters are escaped, control characters replaced by spaces
/// and bytes that are not UTF-8 by U+FFFD.
std::string html_text(const std::string& text);

/// A row of a table of HTML, of cells.
std::string html_row(const std::string& cells);

/// A cell with a text, which is escaped; the same for the head of a column.
std::string html_cell(const std::string& text);
std::string html_header(const std::string& text);

/// An axis of a plot, from `min` to `max` > `min`.
struct PlotAxis {
    std::string label;
    double min = 0;
    double max = 1;
    std::vector<std::string> names{};  ///< of the marks at 0, 1, ..; empty: round numbers
};

/// A diagram with two linear axes, as an SVG element. Values outside of the axes are cut off.
class SvgPlot {
 public:
    SvgPlot(const PlotAxis& x, const PlotAxis& y);

    /// A line through points. `name` is its entry in the legend; empty: none.
    void line(const std::vector<glm::dvec2>& points, const std::string& colour,
              const std::string& name = {});

    /// A vertical line from the lower end of the plot to a point.
    void stem(const glm::dvec2& point, const std::string& colour, const std::string& name = {});

    std::string svg() const;

 private:
    glm::dvec2 pixel(const glm::dvec2& value) const;
    void add_legend(const std::string& colour, const std::string& name);

    PlotAxis x_;
    PlotAxis y_;
    std::string content_;
    std::string legend_;
    int entries_ = 0;
};

/// A marked and named point of a plan.
struct PlanPoint {
    glm::vec2 position{0};
    std::string name;
    bool is_source = false;  ///< a disc; a receiver is a cross
};

/// A floor plan with axes in metres and marked points, as an SVG element.
std::string plan_svg(const RoomSection& plan, const std::vector<PlanPoint>& points);

}  // namespace aula
