#include "apps/documents/report_sections.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "apps/documents/parameter_text.h"
#include "apps/documents/position_average.h"
#include "apps/documents/svg_plot.h"
#include "apps/session/base/formatted.h"
#include "apps/session/offline/measurement_text.h"
#include "engine/response/open_plan.h"
#include "engine/response/speech_transmission.h"

namespace aula {

namespace {

std::string number(const std::optional<double>& value, int decimals) {
    return html_cell(value ? fixed_text(*value, decimals) : "-");
}

/// Speech of a source at a receiver where it is audible.
SpeechAtReceiver speech_of(const RoomReport& report, std::size_t s, std::size_t r) {
    const Measurement& m = report.measurement;
    const Bands levels_db = received_db(m.response(s, r), report.scene.speech.speech_db);
    return {
        .distance_m = double{glm::distance(m.sources[s].position_at(0), m.receivers[r].position)},
        .level_dba = a_weighted_db(levels_db),
        .sti = m.parameters[m.pair(s, r)].sti.value};
}

/// A row of ISO 3382-3, or why there is none.
std::string open_plan_row(const std::string& source, std::span<const SpeechAtReceiver> receivers,
                          bool has_noise) {
    const auto parameters = open_plan_parameters(receivers);
    if (!parameters) {
        const std::size_t count = open_plan_receivers(receivers);
        return html_row(html_cell(source) +
                        formatted("<td colspan=\"4\">%zu receivers at 2 to 16 m%s</td>", count,
                                  count < kOpenPlanReceivers
                                      ? "; at least 4 are needed"
                                      : ", all at one distance; different ones are needed"));
    }
    const std::optional<double> none;
    return html_row(html_cell(source) + number(parameters->d2s_db, 1) +
                    number(parameters->lp_as_4m_dba, 1) +
                    number(has_noise ? parameters->rd_m : none, 1) +
                    number(has_noise ? parameters->rp_m : none, 1));
}

/// Values of responses or pairs, and how they are named.
struct Compared {
    std::string title;
    PairParameters measured;
    PairParameters simulated;
};

/// The pair that a measured response belongs to.
std::optional<std::size_t> pair_named(const RoomReport& report, const std::string& name) {
    const Measurement& m = report.measurement;
    for (std::size_t s = 0; s < m.sources.size(); ++s) {
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            const std::string& receiver = report.receivers[r];
            if (name == m.sources[s].name + " at " + receiver ||
                (m.sources.size() == 1 && name == receiver))
                return m.pair(s, r);
        }
    }
    return std::nullopt;
}

std::vector<Compared> comparisons(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::vector<Compared> all;
    std::vector<const PairParameters*> others;
    for (const MeasuredResponse& response : report.measured) {
        if (const auto pair = pair_named(report, response.name)) {
            const std::size_t s = *pair / m.receivers.size();
            const std::size_t r = *pair % m.receivers.size();
            all.push_back({m.sources[s].name + " at " + report.receivers[r], response.parameters,
                           m.parameters[*pair]});
            const SpeechConditions& speech = report.scene.speech;
            if (response.transfers && m.audible[*pair])
                all.back().measured.sti.value = speech_transmission_index(
                    *response.transfers,
                    ReceivedLevels{.speech_db = received_db(m.response(s, r), speech.speech_db),
                                   .noise_db = speech.noise_db});
        } else {
            others.push_back(&response.parameters);
        }
    }
    if (others.empty()) return all;
    const std::vector<const PairParameters*> pairs = audible_parameters(m);
    all.push_back({"Mean of " + counted(others.size(), "measured response") + " and of " +
                       counted(pairs.size(), "simulated pair"),
                   average_over_positions(others).mean, average_over_positions(pairs).mean});
    return all;
}

/// The difference of a simulated value in just noticeable ones.
std::optional<double> noticeable(const MeasuredValue& simulated, const MeasuredValue& measured,
                                 const ParameterText& text) {
    if (!simulated.value || !measured.value) return std::nullopt;
    const double unit = text.is_share ? text.noticeable * *measured.value : text.noticeable;
    return (*simulated.value - *measured.value) / unit;
}

/// The values of a parameter in octaves, empty for STI, and its single number.
std::vector<const MeasuredValue*> values_of(const PairParameters& of, std::size_t parameter) {
    std::vector<const MeasuredValue*> values;
    static const MeasuredValue kNone;
    for (std::size_t b = 0; b < kBandCount; ++b)
        values.push_back(parameter == kSpeechTransmission ? &kNone : &of.octaves[parameter][b]);
    values.push_back(&single_number(of, parameter));
    return values;
}

std::string comparison_rows(const Compared& compared) {
    std::string rows;
    for (std::size_t p = 0; p < kDescribedParameterCount; ++p) {
        const auto measured = values_of(compared.measured, p);
        if (std::none_of(measured.begin(), measured.end(),
                         [](const MeasuredValue* value) { return value->value.has_value(); }))
            continue;
        const auto simulated = values_of(compared.simulated, p);
        const ParameterText text = parameter_text(p);
        const std::string name = text.symbol + (text.unit.empty() ? "" : " in " + text.unit);
        std::array<std::string, 3> cells{html_cell(name) + html_cell("simulated"),
                                         html_cell("") + html_cell("measured"),
                                         html_cell("") + html_cell("difference in JND")};
        // STI has no octaves.
        const std::size_t first = p == kSpeechTransmission ? kBandCount : 0;
        if (first > 0)
            for (std::string& row : cells) row += formatted("<td colspan=\"%zu\"></td>", first);
        for (std::size_t i = first; i < measured.size(); ++i) {
            cells[0] += number(simulated[i]->value, text.decimals);
            cells[1] += number(measured[i]->value, text.decimals);
            cells[2] += number(noticeable(*simulated[i], *measured[i], text), 1);
        }
        for (const std::string& row : cells) rows += html_row(row);
    }
    return rows;
}

/// T30 of the octaves, of both; T20 where no T30 was measured.
std::string decay_time_plot(const Compared& compared) {
    const auto has = [&](std::size_t p) {
        const auto& octaves = compared.measured.octaves[p];
        return std::any_of(octaves.begin(), octaves.end(),
                           [](const MeasuredValue& value) { return value.value.has_value(); });
    };
    constexpr auto kT30 = static_cast<std::size_t>(AcousticParameter::t30);
    constexpr auto kT20 = static_cast<std::size_t>(AcousticParameter::t20);
    const std::size_t p = has(kT30) ? kT30 : kT20;
    if (!has(p)) return {};
    double largest = 0;
    const auto points = [&](const PairParameters& of) {
        std::vector<glm::dvec2> line;
        for (std::size_t b = 0; b < kBandCount; ++b) {
            if (!of.octaves[p][b].value) continue;
            line.emplace_back(static_cast<double>(b), *of.octaves[p][b].value);
            largest = std::max(largest, line.back().y);
        }
        return line;
    };
    const auto measured = points(compared.measured);
    const auto simulated = points(compared.simulated);
    std::vector<std::string> names;
    for (std::size_t b = 0; b < kBandCount; ++b) names.push_back(band_name(b));
    const std::string symbol = parameter_text(p).symbol;
    SvgPlot plot({"octave in Hz", -0.5, kBandCount - 0.5, names},
                 {symbol + " in s", 0, 1.1 * largest});
    plot.line(simulated, "#0072b2", "simulated");
    plot.line(measured, "#d55e00", "measured");
    return "<figure>\n" + plot.svg() + "<figcaption>" + symbol +
           ", measured and simulated</figcaption>\n</figure>\n";
}

}  // namespace

std::string speech_section(const RoomReport& report) {
    const Measurement& m = report.measurement;
    const SpeechConditions& speech = report.scene.speech;
    std::string pairs;
    std::string offices;
    for (std::size_t s = 0; s < m.sources.size(); ++s) {
        std::vector<SpeechAtReceiver> receivers;
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            if (!m.audible[m.pair(s, r)]) continue;
            const SpeechAtReceiver at = speech_of(report, s, r);
            receivers.push_back(at);
            const auto text = [&](std::string_view (*of)(double)) {
                return html_cell(at.sti ? std::string(of(*at.sti)) : "-");
            };
            pairs += html_row(html_cell(m.sources[s].name) + html_cell(report.receivers[r]) +
                              number(at.distance_m, 2) + number(at.level_dba, 1) +
                              number(at.sti, 2) + text(speech_class) + text(speech_rating));
        }
        offices += open_plan_row(m.sources[s].name, receivers, speech.noise_db.has_value());
    }
    std::string html = "<h2>Speech</h2>\n<table>\n" +
                       html_row(html_header("source") + html_header("receiver") +
                                html_header("distance in m") + html_header("speech in dB(A)") +
                                html_header("STI") + html_header("class") + html_header("rating")) +
                       pairs + "</table>\n" +
                       formatted("<p>Speech of %.0f dB(A) at 1 m", a_weighted_db(speech.speech_db));
    html += speech.noise_db ? formatted("; noise of %.1f dB(A). ", a_weighted_db(*speech.noise_db))
                            : "; no noise. ";
    html +=
        "Classes: IEC 60268-16:2011. Rating: ISO 9921.</p>\n<h3>Open-plan offices (ISO 3382-3)"
        "</h3>\n<table>\n";
    html += html_row(html_header("source") + html_header("D2,S in dB") +
                     html_header("Lp,A,S,4m in dB(A)") + html_header("rD in m") +
                     html_header("rP in m"));
    html += offices +
            "</table>\n<p>With the speech above; that of ISO 3382-3 has 57.4 dB(A). "
            "Distances beyond the farthest receiver are extrapolated.";
    if (!speech.noise_db) html += " rD and rP need a level of noise.";
    return html + "</p>\n";
}

std::string measured_section(const RoomReport& report) {
    const std::vector<Compared> all = comparisons(report);
    if (all.empty()) return {};
    std::string html = "<h2>Comparison with measured values</h2>\n";
    std::string header = html_header("") + html_header("");
    for (std::size_t b = 0; b < kBandCount; ++b) header += html_header(band_name(b));
    header += html_header("single number");
    for (const Compared& compared : all)
        html += "<section>\n<h3>" + html_text(compared.title) + "</h3>\n<table class=\"wide\">\n" +
                html_row(header) + comparison_rows(compared) + "</table>\n" +
                decay_time_plot(compared) + "</section>\n";
    return html +
           "<p>Differences are simulated minus measured, in just noticeable differences (ISO "
           "3382-1, annex A): 5 % for T20, T30 and EDT, 1 dB for C50, C80 and G, 0.05 for D50, "
           "10 ms for Ts, 0.03 for STI. STI of a sound file is that with the simulated level of "
           "speech at its receiver, and with the noise; a sound file without a receiver has none. "
           "STI of a table is as given.</p>\n";
}

}  // namespace aula
