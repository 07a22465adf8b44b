#include "apps/documents/svg_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

#include "apps/documents/value_scale.h"
#include "apps/output/formatted.h"

namespace aula {

namespace {

// Pixels.
constexpr glm::dvec2 kSize{460, 270};
constexpr glm::dvec2 kCorner{54, 12};  ///< of the diagram's area
constexpr glm::dvec2 kArea{310, 214};

constexpr const char* kPlanSource = "#1a8cf2";
constexpr const char* kPlanReceiver = "#c03020";

/// Length in bytes of the valid UTF-8 character at `at`; 0 if there is none.
std::size_t character_length(const std::string& text, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
    };
    const unsigned first = byte(at);
    if (first < 0x80) return 1;
    const std::size_t length = first >= 0xC2 && first < 0xE0   ? 2
                               : first >= 0xE0 && first < 0xF0 ? 3
                               : first >= 0xF0 && first < 0xF5 ? 4
                                                               : 0;
    for (std::size_t i = 1; i < length; ++i)
        if (byte(at + i) >> 6 != 2) return 0;
    // Overlong forms, surrogates and numbers beyond U+10FFFF.
    const unsigned second = byte(at + 1);
    const bool wrong = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                       (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
    return wrong ? 0 : length;
}

std::string line_element(const glm::dvec2& from, const glm::dvec2& to, const std::string& colour,
                         double width) {
    return formatted("<line x1=\"%.2f\" y1=\"%.2f\" x2=\"%.2f\" y2=\"%.2f\" ", from.x, from.y, to.x,
                     to.y) +
           "stroke=\"" + colour + formatted("\" stroke-width=\"%g\"/>\n", width);
}

/// `anchor` is start, middle or end; `text` is escaped.
std::string text_element(const glm::dvec2& at, const char* anchor, const std::string& text) {
    return formatted("<text x=\"%.2f\" y=\"%.2f\" text-anchor=\"%s\">", at.x, at.y, anchor) +
           html_text(text) + "</text>\n";
}

std::string svg_element(const glm::dvec2& size, const std::string& content) {
    return formatted(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
               "width=\"%.0f\" height=\"%.0f\" font-size=\"11\">\n",
               size.x, size.y, size.x, size.y) +
           content + "</svg>\n";
}

/// A mark of an axis.
struct Mark {
    double at = 0;
    std::string name;
};

/// The marks of an axis, at most `most` round numbers.
std::vector<Mark> marks_of(const PlotAxis& axis, int most) {
    std::vector<Mark> marks;
    for (std::size_t i = 0; i < axis.names.size(); ++i)
        marks.push_back({static_cast<double>(i), axis.names[i]});
    if (!marks.empty()) return marks;
    const std::vector<double> numbers = round_numbers(axis.min, axis.max, most);
    for (const double at : numbers) marks.push_back({at, fixed_text(at, decimals_of(numbers))});
    return marks;
}

/// The names of points in a plan: beside their marks, where no other mark or name is.
class PlanLabels {
 public:
    void add_mark(const glm::dvec2& at) { taken_.push_back({at - 6.0, at + 6.0}); }

    /// The name of a point, whose mark has been added; it ends before `most_x` if possible.
    std::string element(const glm::dvec2& at, const std::string& name, double most_x) {
        // Pixels of the font of 11: a character, and the parts above and below the base line.
        const glm::dvec2 extent(6.8 * static_cast<double>(name.size()), 0);
        constexpr double kAbove = 9;
        constexpr double kBelow = 3;
        constexpr std::array<glm::dvec2, 6> kPlaces{
            {{9, 4}, {-9, 4}, {9, -10}, {9, 17}, {-9, -10}, {-9, 17}}};
        Area area{};
        for (const glm::dvec2& place : kPlaces) {
            const glm::dvec2 base = at + place;
            const glm::dvec2 left = place.x < 0 ? base - extent : base;
            area = {left - glm::dvec2(0, kAbove), left + extent + glm::dvec2(0, kBelow)};
            if (area.low.x < 0 || area.high.x > most_x || is_taken(area)) continue;
            taken_.push_back(area);
            return text_element(base, place.x < 0 ? "end" : "start", name);
        }
        return text_element(at + kPlaces[0], "start", name);
    }

 private:
    struct Area {
        glm::dvec2 low;
        glm::dvec2 high;
    };

    bool is_taken(const Area& area) const {
        return std::any_of(taken_.begin(), taken_.end(), [&](const Area& other) {
            return area.low.x < other.high.x && other.low.x < area.high.x &&
                   area.low.y < other.high.y && other.low.y < area.high.y;
        });
    }

    std::vector<Area> taken_;
};

}  // namespace

std::string html_text(const std::string& text) {
    std::string html;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = character_length(text, i);
        const char c = text[i];
        if (length == 0) {
            html += "\xEF\xBF\xBD";
        } else if (length > 1) {
            html += text.substr(i, length);
        } else if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') {
            html += ' ';
        } else {
            switch (c) {
                case '&':
                    html += "&amp;";
                    break;
                case '<':
                    html += "&lt;";
                    break;
                case '>':
                    html += "&gt;";
                    break;
                case '"':
                    html += "&quot;";
                    break;
                case '\'':
                    html += "&#39;";
                    break;
                default:
                    html += c;
            }
        }
        i += std::max<std::size_t>(length, 1);
    }
    return html;
}

std::string html_row(const std::string& cells) { return "<tr>" + cells + "</tr>\n"; }

std::string html_cell(const std::string& text) { return "<td>" + html_text(text) + "</td>"; }

std::string html_header(const std::string& text) { return "<th>" + html_text(text) + "</th>"; }

SvgPlot::SvgPlot(const PlotAxis& x, const PlotAxis& y) : x_(x), y_(y) {}

glm::dvec2 SvgPlot::pixel(const glm::dvec2& value) const {
    return kCorner + kArea * glm::dvec2((value.x - x_.min) / (x_.max - x_.min),
                                        (y_.max - value.y) / (y_.max - y_.min));
}

void SvgPlot::add_legend(const std::string& colour, const std::string& name) {
    if (name.empty()) return;
    const glm::dvec2 at = kCorner + glm::dvec2(kArea.x + 12, 10 + 18 * entries_++);
    legend_ += line_element(at, at + glm::dvec2(18, 0), colour, 2) +
               text_element(at + glm::dvec2(24, 4), "start", name);
}

void SvgPlot::line(const std::vector<glm::dvec2>& points, const std::string& colour,
                   const std::string& name) {
    std::string list;
    for (const glm::dvec2& point : points) {
        const glm::dvec2 at = pixel(point);
        list += formatted("%.2f,%.2f ", at.x, at.y);
    }
    if (!list.empty()) list.pop_back();
    content_ += "<polyline fill=\"none\" stroke-width=\"1.3\" stroke=\"" + colour + "\" points=\"" +
                list + "\"/>\n";
    add_legend(colour, name);
}

void SvgPlot::stem(const glm::dvec2& point, const std::string& colour, const std::string& name) {
    if (point.y > y_.min && point.x >= x_.min && point.x <= x_.max)
        content_ += line_element(pixel({point.x, y_.min}), pixel(point), colour, 1.3);
    add_legend(colour, name);
}

std::string SvgPlot::svg() const {
    constexpr const char* kGrid = "#dddddd";
    std::string axes;
    for (const auto& [at, name] : marks_of(x_, 6)) {
        const double x = pixel({at, y_.min}).x;
        axes += line_element({x, kCorner.y}, {x, kCorner.y + kArea.y}, kGrid, 1) +
                text_element({x, kCorner.y + kArea.y + 15}, "middle", name);
    }
    for (const auto& [at, name] : marks_of(y_, 7)) {
        const double y = pixel({x_.min, at}).y;
        axes += line_element({kCorner.x, y}, {kCorner.x + kArea.x, y}, kGrid, 1) +
                text_element({kCorner.x - 6, y + 4}, "end", name);
    }
    axes += text_element(kCorner + glm::dvec2(kArea.x / 2, kArea.y + 34), "middle", x_.label);
    axes += formatted(
                "<text transform=\"translate(13 %.0f) rotate(-90)\" "
                "text-anchor=\"middle\">",
                kCorner.y + kArea.y / 2) +
            html_text(y_.label) + "</text>\n";
    // A nested SVG element cuts off what is outside of the diagram.
    const std::string inside =
        formatted("<svg x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\" viewBox=\"%g %g %g %g\">\n",
                  kCorner.x, kCorner.y, kArea.x, kArea.y, kCorner.x, kCorner.y, kArea.x, kArea.y) +
        content_ + "</svg>\n";
    const std::string frame = formatted(
        "<rect x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\" fill=\"none\" "
        "stroke=\"#666666\"/>\n",
        kCorner.x, kCorner.y, kArea.x, kArea.y);
    return svg_element(kSize, axes + inside + frame + legend_);
}

std::string plan_svg(const RoomSection& plan, const std::vector<PlanPoint>& points) {
    constexpr double kLongest = 620;
    constexpr double kHighest = 420;
    constexpr glm::dvec2 kFrom{46, 14};
    // The plan contains points outside of the room.
    glm::dvec2 min(plan.min);
    glm::dvec2 max(plan.max);
    if (plan.walls.empty() && !points.empty()) min = max = glm::dvec2(points[0].position);
    for (const PlanPoint& point : points) {
        min = glm::min(min, glm::dvec2(point.position));
        max = glm::max(max, glm::dvec2(point.position));
    }
    const glm::dvec2 size_m = glm::max(max - min, glm::dvec2(0.1));
    const double scale = std::min(kLongest / size_m.x, kHighest / size_m.y);
    const glm::dvec2 size = size_m * scale;
    const auto pixel = [&](const glm::dvec2& m) {
        return kFrom + glm::dvec2((m.x - min.x) * scale, size.y - (m.y - min.y) * scale);
    };
    std::string content;
    for (const auto& [from, to] : plan.walls)
        content += line_element(pixel(glm::dvec2(from)), pixel(glm::dvec2(to)), "#222222", 1.5);
    const auto marks = [](double from, double to, double length) {
        return round_numbers(from, to, std::max(1, static_cast<int>(length / 60)));
    };
    const std::vector<double> along_x = marks(min.x, max.x, size.x);
    for (const double at : along_x) {
        const glm::dvec2 mark = pixel({at, min.y}) + glm::dvec2(0, 8);
        content +=
            line_element(mark, mark + glm::dvec2(0, 5), "#666666", 1) +
            text_element(mark + glm::dvec2(0, 17), "middle", fixed_text(at, decimals_of(along_x)));
    }
    const std::vector<double> along_y = marks(min.y, max.y, size.y);
    for (const double at : along_y) {
        const glm::dvec2 mark = pixel({min.x, at}) - glm::dvec2(8, 0);
        content +=
            line_element(mark, mark - glm::dvec2(5, 0), "#666666", 1) +
            text_element(mark + glm::dvec2(-8, 4), "end", fixed_text(at, decimals_of(along_y)));
    }
    content += text_element(kFrom + glm::dvec2(size.x / 2, size.y + 42), "middle", "x and y in m");
    PlanLabels labels;
    for (const PlanPoint& point : points) {
        const glm::dvec2 at = pixel(glm::dvec2(point.position));
        labels.add_mark(at);
        if (point.is_source) {
            content += formatted("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"5\" fill=\"%s\"/>\n", at.x,
                                 at.y, kPlanSource);
        } else {
            content +=
                line_element(at - glm::dvec2(5, 5), at + glm::dvec2(5, 5), kPlanReceiver, 2) +
                line_element(at - glm::dvec2(5, -5), at + glm::dvec2(5, -5), kPlanReceiver, 2);
        }
    }
    for (const PlanPoint& point : points)
        content += labels.element(pixel(glm::dvec2(point.position)), point.name, kFrom.x + size.x);
    return svg_element(kFrom + size + glm::dvec2(80, 56), content);
}

}  // namespace aula
