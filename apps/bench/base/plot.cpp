#include "apps/bench/base/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

#include "apps/session/base/output_file.h"

namespace aula::bench {

namespace {

constexpr double kPanelWidth = 300;
constexpr double kPanelHeight = 230;
constexpr double kLeft = 56;  // of a panel, for numbers
constexpr double kRight = 14;
constexpr double kTop = 34;
constexpr double kBottom = 46;
constexpr double kHead = 66;  // title and legend
constexpr std::size_t kPanelsInRow = 3;

/// Told apart by the colour-blind, too (Okabe and Ito).
constexpr std::array<const char*, 4> kColours{"#777777", "#d55e00", "#009e73", "#0072b2"};

struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = 0;

    void include(double x) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
    /// From 0 to 1 on a logarithmic scale.
    double share(double x) const { return std::log(x / low) / std::log(high / low); }
};

std::string text_of(double x) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", x);
    return text.data();
}

/// 1, 2 and 5 times powers of ten inside a range; powers alone where these are many.
std::vector<double> ticks(const Range& range) {
    std::vector<double> all;
    const bool wide = range.high / range.low > 300;
    const int first = static_cast<int>(std::floor(std::log10(range.low)));
    const int last = static_cast<int>(std::ceil(std::log10(range.high)));
    for (int power = first; power <= last; ++power) {
        for (const double step : {1.0, 2.0, 5.0}) {
            if (wide && step > 1) continue;
            const double tick = step * std::pow(10.0, power);
            if (tick >= range.low * 0.999 && tick <= range.high * 1.001) all.push_back(tick);
        }
    }
    return all;
}

void text(std::ostream& out, double x, double y, const char* anchor, const std::string& content,
          const char* more = "") {
    out << "<text x=\"" << x << "\" y=\"" << y << "\" text-anchor=\"" << anchor << "\"" << more
        << ">" << content << "</text>\n";
}

void line(std::ostream& out, double x0, double y0, double x1, double y1) {
    out << "<line x1=\"" << x0 << "\" y1=\"" << y0 << "\" x2=\"" << x1 << "\" y2=\"" << y1
        << "\" stroke=\"#dddddd\"/>\n";
}

void draw_panel(std::ostream& out, const PlotPanel& panel, const std::string& x_title) {
    Range xs;
    Range ys;
    for (const PlotCurve& curve : panel.curves) {
        for (const auto& [x, y] : curve.points) {
            if (!(x > 0) || !(y > 0)) continue;
            xs.include(x);
            ys.include(y);
        }
    }
    if (!(xs.high > 0)) return;
    // Room around the curves, and at least a factor of two to see.
    const double spare = std::max(1.1, std::sqrt(2 / (ys.high / ys.low)));
    ys = {ys.low / spare, ys.high * spare};
    if (xs.high == xs.low) xs = {xs.low / 2, xs.high * 2};
    const double width = kPanelWidth - kLeft - kRight;
    const double height = kPanelHeight - kTop - kBottom;
    const auto at_x = [&](double x) { return kLeft + width * xs.share(x); };
    const auto at_y = [&](double y) { return kTop + height * (1 - ys.share(y)); };

    text(out, kLeft + width / 2, kTop - 12, "middle", panel.title, " font-weight=\"bold\"");
    for (const double x : ticks(xs)) {
        line(out, at_x(x), kTop, at_x(x), kTop + height);
        text(out, at_x(x), kTop + height + 16, "middle", text_of(x));
    }
    for (const double y : ticks(ys)) {
        line(out, kLeft, at_y(y), kLeft + width, at_y(y));
        text(out, kLeft - 6, at_y(y) + 4, "end", text_of(y));
    }
    text(out, kLeft + width / 2, kPanelHeight - 10, "middle", x_title);
    out << "<rect x=\"" << kLeft << "\" y=\"" << kTop << "\" width=\"" << width << "\" height=\""
        << height << "\" fill=\"none\" stroke=\"#888888\"/>\n";
    for (std::size_t i = 0; i < panel.curves.size(); ++i) {
        const char* colour = kColours[i % kColours.size()];
        out << "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"" << colour << "\" points=\"";
        for (const auto& [x, y] : panel.curves[i].points) {
            if (x > 0 && y > 0) out << at_x(x) << "," << at_y(y) << " ";
        }
        out << "\"/>\n";
        for (const auto& [x, y] : panel.curves[i].points) {
            if (!(x > 0) || !(y > 0)) continue;
            out << "<circle cx=\"" << at_x(x) << "\" cy=\"" << at_y(y) << "\" r=\"3\" fill=\""
                << colour << "\"/>\n";
        }
    }
}

}  // namespace

void write_plot(const std::filesystem::path& file, const std::string& title,
                const std::string& x_title, const std::vector<PlotPanel>& panels) {
    const std::size_t rows = (panels.size() + kPanelsInRow - 1) / kPanelsInRow;
    const double width = kPanelWidth * static_cast<double>(std::min(panels.size(), kPanelsInRow));
    const double height = kHead + kPanelHeight * static_cast<double>(rows);
    std::ostringstream out;
    out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width << "\" height=\"" << height
        << "\" viewBox=\"0 0 " << width << " " << height
        << "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#222222\">\n"
        << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    text(out, width / 2, 24, "middle", title, " font-size=\"15\"");
    if (!panels.empty()) {
        const auto& curves = panels.front().curves;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            const double x =
                width / 2 + 140 * (static_cast<double>(i) - static_cast<double>(curves.size()) / 2);
            out << "<line x1=\"" << x << "\" y1=\"46\" x2=\"" << x + 26
                << "\" y2=\"46\" stroke-width=\"3\" stroke=\"" << kColours[i % kColours.size()]
                << "\"/>\n";
            text(out, x + 32, 50, "start", curves[i].name);
        }
    }
    for (std::size_t i = 0; i < panels.size(); ++i) {
        out << "<g transform=\"translate(" << kPanelWidth * static_cast<double>(i % kPanelsInRow)
            << " " << kHead + kPanelHeight * static_cast<double>(i / kPanelsInRow) << ")\">\n";
        draw_panel(out, panels[i], x_title);
        out << "</g>\n";
    }
    out << "</svg>\n";
    OutputFile output(file);
    output.write(out.str());
    output.commit();
}

}  // namespace aula::bench
