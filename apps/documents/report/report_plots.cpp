#include "apps/documents/report/report_plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "apps/documents/svg_plot.h"
#include "apps/room/offline/measurement_text.h"
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
    for (const SoundPath& path : response.paths)
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
        for (const SoundPath& path : response.paths) {
            if (std::min(path.order, 2) != kind.order) continue;
            plot.stem({1000 * response.arrival_s(path), strength_db(path.energy[kBand])},
                      kind.colour, name);
            name.clear();
        }
    }
    return plot.svg();
}

std::string decay_time_svg(const PositionAverage& average,
                           const std::optional<double>& schroeder_hz) {
    constexpr auto kT30 = static_cast<std::size_t>(AcousticParameter::t30);
    constexpr const char* kMean = "#0072b2";
    constexpr const char* kGrey = "#999999";
    std::vector<std::string> names;
    std::vector<glm::dvec2> means;
    std::vector<std::array<glm::dvec2, 2>> bars;
    double largest_s = 0;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        names.push_back(band_name(b));
        const std::optional<double>& mean_s = average.mean.octaves[kT30][b].value;
        if (!mean_s) continue;
        const double spread_s = average.deviation.octaves[kT30][b].value.value_or(0);
        const auto x = static_cast<double>(b);
        means.emplace_back(x, *mean_s);
        bars.push_back({glm::dvec2(x, *mean_s - spread_s), glm::dvec2(x, *mean_s + spread_s)});
        largest_s = std::max(largest_s, *mean_s + spread_s);
    }
    if (means.empty()) return {};
    SvgPlot plot({"octave in Hz", -0.5, kBandCount - 0.5, names}, {"T30 in s", 0, 1.1 * largest_s});
    const auto is_valid = [&](const glm::dvec2& point) {
        return !schroeder_hz ||
               double{kBandCentres_hz[static_cast<std::size_t>(point.x)]} >= *schroeder_hz;
    };
    // The part below the Schroeder frequency ends where the other begins.
    const auto first_valid = std::find_if(means.begin(), means.end(), is_valid);
    if (first_valid != means.begin())
        plot.line({means.begin(), first_valid == means.end() ? first_valid : first_valid + 1},
                  kGrey, "below f_S");
    if (first_valid != means.end()) plot.line({first_valid, means.end()}, kMean, "mean");
    bool is_named = false;
    for (const auto& [low, high] : bars) {
        if (low.y == high.y) continue;
        constexpr double kCap = 0.06;
        const char* const colour = is_valid(low) ? kMean : kGrey;
        const bool names_it = is_valid(low) && !is_named;
        plot.line({low, high}, colour, names_it ? "deviation" : "");
        is_named = is_named || names_it;
        for (const glm::dvec2& end : {low, high})
            plot.line({end - glm::dvec2(kCap, 0), end + glm::dvec2(kCap, 0)}, colour);
    }
    return plot.svg();
}

}  // namespace aula
