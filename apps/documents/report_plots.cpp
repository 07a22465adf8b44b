#include "apps/documents/report_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/documents/svg_plot.h"
#include "apps/session/offline/measurement_text.h"
#include "engine/response/time_zero.h"

namespace aula {

namespace {

/// Colours that differ for readers with colour blindness (Okabe and Ito 2008), [band].
constexpr std::array<const char*, kBandCount> kBandColours{
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#888888"};

constexpr double kSilence_db = -200;

double decibels(double energy) { return energy > 1e-20 ? 10 * std::log10(energy) : kSilence_db; }

/// Level of an energy re the free field at 10 m.
double strength_db(float energy) {
    return decibels(400 * std::numbers::pi * static_cast<double>(energy));
}

}  // namespace

std::string decay_svg(const EnergyResponse& response) {
    constexpr double kLowest_db = -70;
    const double step_s = std::max(1e-3, response.bins.length_s() / 400);
    const std::vector<Bands> steps = response.uniform(step_s);
    SvgPlot plot({"time after emission in s", 0, std::max(response.bins.length_s(), step_s)},
                 {"level in dB re the total", kLowest_db, 0});
    for (std::size_t band = 0; band < kBandCount; ++band) {
        std::vector<double> rest(steps.size() + 1);
        for (std::size_t i = steps.size(); i-- > 0;)
            rest[i] = rest[i + 1] + static_cast<double>(steps[i][band]);
        std::vector<glm::dvec2> points;
        for (std::size_t i = 0; i < steps.size() && rest[0] > 0; ++i) {
            const double level_db = decibels(rest[i] / rest[0]);
            points.emplace_back(static_cast<double>(i) * step_s, level_db);
            if (level_db < kLowest_db) break;
        }
        plot.line(points, kBandColours[band], band_name(band) + " Hz");
    }
    return plot.svg();
}

std::string echogram_svg(const EnergyResponse& response) {
    constexpr std::size_t kBand = 4;
    constexpr double kShown_s = 0.2;
    constexpr double kStep_s = 1e-3;
    constexpr double kRange_db = 50;
    const double from_s = time_zero_s(response);
    const std::vector<Bands> steps = response.uniform(kStep_s);
    const auto first = static_cast<std::size_t>(std::max(0.0, from_s / kStep_s - 5));
    std::vector<glm::dvec2> points;
    double highest_db = kSilence_db;
    for (std::size_t i = first; i < steps.size() && i < first + 200; ++i) {
        const double level_db = strength_db(steps[i][kBand]);
        const double time_ms = 1000 * kStep_s * static_cast<double>(i);
        points.emplace_back(time_ms, level_db);
        points.emplace_back(time_ms + 1000 * kStep_s, level_db);
        highest_db = std::max(highest_db, level_db);
    }
    for (const SpecularPath& path : response.paths)
        highest_db = std::max(highest_db, strength_db(path.energy[kBand]));
    const double top_db = 5 * std::ceil(highest_db / 5 + 0.2);
    const double begin_ms = 1000 * kStep_s * static_cast<double>(first);
    SvgPlot plot({"time after emission in ms", begin_ms, begin_ms + 1000 * kShown_s},
                 {"level in dB re free field at 10 m", top_db - kRange_db, top_db});
    plot.line(points, "#999999", "per ms");
    // The direct sound last, above reflections that arrive at nearly the same time.
    struct Kind {
        int order;
        const char* colour;
        const char* name;
    };
    constexpr std::array<Kind, 3> kKinds{
        {{2, "#0072b2", "order 2 on"}, {1, "#d55e00", "order 1"}, {0, "#000000", "direct"}}};
    for (const Kind& kind : kKinds) {
        std::string name = kind.name;
        for (const SpecularPath& path : response.paths) {
            if (std::min(path.order, 2) != kind.order) continue;
            plot.stem({1000 * response.arrival_s(path), strength_db(path.energy[kBand])},
                      kind.colour, name);
            name.clear();
        }
    }
    return plot.svg();
}

}  // namespace aula
