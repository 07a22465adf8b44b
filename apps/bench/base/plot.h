#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace aula::bench {

/// A line through points (x, y), both above 0.
struct PlotCurve {
    std::string name;
    std::vector<std::pair<double, double>> points;
};

/// One set of axes, both logarithmic.
struct PlotPanel {
    std::string title;
    std::vector<PlotCurve> curves;
};

/// Writes panels, three in a row, with one legend for the curves of the same name as an SVG file.
/// Throws Error or AudioFailure (disk full) if it cannot be written; then no part is left.
void write_plot(const std::filesystem::path& file, const std::string& title,
                const std::string& x_title, const std::vector<PlotPanel>& panels);

}  // namespace aula::bench
