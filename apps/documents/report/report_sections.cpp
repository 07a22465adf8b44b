#include "apps/documents/report/report_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "apps/documents/parameter_text.h"
#include "apps/documents/position_average.h"
#include "apps/documents/report/report_cells.h"
#include "apps/documents/svg_plot.h"
#include "apps/output/formatted.h"
#include "apps/room/edit/scene_state.h"
#include "apps/room/offline/acoustic_parameters.h"
#include "apps/room/offline/measurement_text.h"
#include "engine/response/open_plan.h"
#include "engine/response/speech_transmission.h"

namespace aula {

namespace {

/// Speech of a source at a receiver: its level in dB(A) and STI, with their standard errors.
struct PairSpeech {
    MeasuredValue level_dba;
    MeasuredValue sti;
};

/// The level with the largest change of it by the standard errors of its octaves, from 125 Hz on,
/// which share their rays.
MeasuredValue level_dba(const Bands& levels_db, const PairParameters& parameters) {
    Bands higher_db = levels_db;
    MeasuredValue level{a_weighted_db(levels_db), {}};
    for (std::size_t b = 1; b < kBandCount; ++b) {
        const std::optional<double>& error_db =
            parameters.octave(AcousticParameter::g, b).standard_error;
        if (!error_db) return level;
        higher_db[b] += static_cast<float>(*error_db);
    }
    level.standard_error = a_weighted_db(higher_db) - *level.value;
    return level;
}

/// A level in dB(A). The octave levels of a spectrum are rounded to 0.1 dB, so that their sum may
/// differ by as much from the level that was given.
std::string level_text(const Bands& levels_db) {
    constexpr double kRounding_db = 0.1;
    const double level_dba = a_weighted_db(levels_db);
    const bool is_whole = std::abs(level_dba - std::round(level_dba)) < kRounding_db;
    return fixed_text(level_dba, is_whole ? 0 : 1);
}

/// The conditions of speech with the level of an omnidirectional source of the power of a source.
SpeechConditions speech_of(const RoomReport& report, std::size_t source) {
    return with_power_of(report.scene.speech, report.measurement.sources[source].directivity);
}

PairSpeech speech_at(const RoomReport& report, std::size_t s, std::size_t r) {
    const Measurement& m = report.measurement;
    const PairParameters& parameters = m.parameters[m.pair(s, r)];
    return {level_dba(received_db(m.response(s, r), speech_of(report, s).speech_db), parameters),
            parameters.sti};
}

/// The single numbers of ISO 3382-3 of a talker with their errors, of all receivers by the speech
/// of the standard.
class OpenPlanRow {
 public:
    OpenPlanRow(const RoomReport& report, std::size_t s) : report_(report), source_(s) {
        const Measurement& m = report.measurement;
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            if (!m.audible[m.pair(s, r)]) continue;
            const Vec3 from_talker = m.receivers[r].position - m.sources[s].position_at(0);
            if (from_talker == Vec3(0)) continue;
            const PairParameters& parameters = m.parameters[m.pair(s, r)];
            const MeasuredValue level =
                level_dba(received_db(m.response(s, r), kOpenPlanSpeech_db), parameters);
            names_.push_back(report.receivers[r]);
            receivers_.push_back({from_talker, *level.value,
                                  parameters.sti.value ? speech_transmission_index(
                                                             m.response(s, r), kOpenPlanSpeech_db,
                                                             report.scene.speech.noise_db)
                                                       : std::nullopt});
            errors_.push_back({level.standard_error, parameters.sti.standard_error});
        }
        values_ = open_plan_parameters(receivers_);
    }

    /// Empty without a line of receivers.
    std::string html() const {
        if (!values_) return {};
        std::string line;
        for (const std::size_t i : values_->line) line += (line.empty() ? "" : ", ") + names_[i];
        const bool has_noise = report_.scene.speech.noise_db.has_value();
        return html_row(html_cell(report_.measurement.sources[source_].name) + html_cell(line) +
                        cell(values_->d2s_db, &OpenPlanParameters::d2s_db) +
                        cell(values_->lp_as_4m_dba, &OpenPlanParameters::lp_as_4m_dba) +
                        (has_noise ? cell(values_->rd_m, &OpenPlanParameters::rd_m) +
                                         cell(values_->rp_m, &OpenPlanParameters::rp_m)
                                   : html_cell("-") + html_cell("-")));
    }

 private:
    struct Errors {
        std::optional<double> level_db;
        std::optional<double> sti;
    };

    /// A cell with an error: the sum of what the errors of the receivers of the line change; none
    /// if one of them has none.
    template <typename Member>
    std::string cell(const std::optional<double>& value, Member member) const {
        MeasuredValue with_error{value, {}};
        if (!value) return value_cell(with_error, 1);
        for (const std::size_t i : values_->line) {
            if (!errors_[i].level_db) return value_cell({value, {}}, 1);
            std::vector<SpeechAtReceiver> changed = receivers_;
            changed[i].level_dba += *errors_[i].level_db;
            if (changed[i].sti) *changed[i].sti += errors_[i].sti.value_or(0);
            const auto other = open_plan_parameters(changed);
            const std::optional<double> moved = (*other).*member;
            with_error.standard_error =
                with_error.standard_error.value_or(0) + std::abs(moved.value_or(*value) - *value);
        }
        return value_cell(with_error, 1);
    }

    const RoomReport& report_;
    std::size_t source_;
    std::vector<std::string> names_;           ///< of `receivers_`
    std::vector<SpeechAtReceiver> receivers_;  ///< where the talker is audible
    std::vector<Errors> errors_;               ///< [receiver]
    std::optional<OpenPlanParameters> values_;
};

/// ISO 3382-3 of all talkers, or what is missing for it.
std::string open_plan_section(const RoomReport& report) {
    const Measurement& m = report.measurement;
    std::string rows;
    bool is_directed = false;
    for (std::size_t s = 0; s < m.sources.size(); ++s) {
        const Directivity& directivity = m.sources[s].directivity;
        if (!directivity.is_omnidirectional() && directivity_name(m.sources[s]) != "talker")
            continue;
        const std::string row = OpenPlanRow(report, s).html();
        is_directed = is_directed || (!row.empty() && !directivity.is_omnidirectional());
        rows += row;
    }
    if (rows.empty())
        return formatted(
            "<p>No values of ISO 3382-3 (open-plan offices): they need at least %zu receivers in "
            "one direction from a talker, within ±%g°, on one floor (±%g m), at distances of %g to "
            "%g m, the farthest at least twice as far as the nearest.</p>\n",
            kOpenPlanReceivers, kOpenPlanAngle_deg, kOpenPlanLevel_m, kOpenPlanFrom_m,
            kOpenPlanTo_m);
    std::string html =
        "<h3>Open-plan offices (ISO 3382-3)</h3>\n<table class=\"pairs\">\n" +
        head_row(html_header("source") + html_header("line of receivers") +
                 html_header("D2,S in dB") + html_header("Lp,A,S,4m in dB(A)") +
                 html_header("rD in m") + html_header("rP in m")) +
        rows +
        formatted(
            "</table>\n<p>With the speech of the standard, %.1f dB(A) at 1 m as the mean over "
            "directions. Distances beyond the farthest receiver are extrapolated. ± adds up "
            "the standard errors of all receivers.",
            a_weighted_db(kOpenPlanSpeech_db));
    if (is_directed) html += " The standard asks for an omnidirectional source.";
    if (!report.scene.speech.noise_db) html += " rD and rP need a level of noise.";
    return html + "</p>\n";
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
    std::string names;
    for (const MeasuredResponse& response : report.measured) {
        if (const auto pair = pair_named(report, response.name)) {
            const std::size_t s = *pair / m.receivers.size();
            const std::size_t r = *pair % m.receivers.size();
            all.push_back({m.sources[s].name + " at " + report.receivers[r], response.parameters,
                           m.parameters[*pair]});
            const SpeechConditions speech = speech_of(report, s);
            if (response.transfers && m.audible[*pair])
                all.back().measured.sti.value = speech_transmission_index(
                    *response.transfers,
                    ReceivedLevels{.speech_db = received_db(m.response(s, r), speech.speech_db),
                                   .noise_db = speech.noise_db});
        } else if (const auto receiver =
                       std::find(report.receivers.begin(), report.receivers.end(), response.name);
                   receiver != report.receivers.end()) {
            std::vector<const PairParameters*> of_sources;
            const auto r = static_cast<std::size_t>(receiver - report.receivers.begin());
            for (std::size_t s = 0; s < m.sources.size(); ++s)
                if (m.audible[m.pair(s, r)]) of_sources.push_back(&m.parameters[m.pair(s, r)]);
            all.push_back({"Mean of " + counted(of_sources.size(), "source") + " at " + *receiver,
                           response.parameters, average_over_positions(of_sources).mean});
        } else {
            others.push_back(&response.parameters);
            names += (names.empty() ? "" : ", ") + response.name;
        }
    }
    if (others.empty()) return all;
    const std::vector<const PairParameters*> pairs = audible_parameters(m, report.in_room);
    all.push_back({"Mean of " + counted(others.size(), "measured response") + " (" + names +
                       ") and of " + counted(pairs.size(), "simulated pair"),
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
            cells[0] += number_cell(simulated[i]->value, text.decimals);
            cells[1] += number_cell(measured[i]->value, text.decimals);
            cells[2] += number_cell(noticeable(*simulated[i], *measured[i], text), 1);
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
    for (std::size_t s = 0; s < m.sources.size(); ++s) {
        for (std::size_t r = 0; r < m.receivers.size(); ++r) {
            if (!m.audible[m.pair(s, r)]) continue;
            const auto [level, sti] = speech_at(report, s, r);
            const double margin = speech_margin(sti);
            const auto name = [&, &index = sti.value](std::string_view (*of)(double)) {
                return html_cell(index ? speech_name(*index, margin, of) : "-");
            };
            const double distance_m =
                double{glm::distance(m.sources[s].position_at(0), m.receivers[r].position)};
            pairs += html_row(html_cell(m.sources[s].name) + html_cell(report.receivers[r]) +
                              number_cell(distance_m, 2) + value_cell(level, 1) +
                              value_cell(sti, 2) + name(speech_class) + name(speech_rating));
        }
    }
    std::string html = "<h2>Speech</h2>\n<table class=\"pairs\">\n" +
                       head_row(html_header("source") + html_header("receiver") +
                                html_header("distance in m") + html_header("speech in dB(A)") +
                                html_header("STI") + html_header("class") + html_header("rating")) +
                       pairs + "</table>\n" + "<p>Speech of " + level_text(speech.speech_db) +
                       " dB(A) at 1 m in free field on the axis of a source; ";
    html +=
        speech.noise_db ? "noise of " + level_text(*speech.noise_db) + " dB(A). " : "no noise. ";
    return html +
           "Classes: IEC 60268-16:2011. Rating: ISO 9921. Two names: the limit between them is "
           "within two standard errors of STI, or within its last digit.</p>\n" +
           open_plan_section(report);
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
                head_row(header) + comparison_rows(compared) + "</table>\n" +
                decay_time_plot(compared) + "</section>\n";
    return html +
           "<p>Differences are simulated minus measured, in just noticeable differences (ISO "
           "3382-1, annex A): 5 % for T20, T30 and EDT, 1 dB for C50, C80 and G, 0.05 for D50, "
           "10 ms for Ts, 0.03 for STI. STI of a sound file is that with the simulated level of "
           "speech at its receiver, and with the noise; a sound file without a receiver has none. "
           "STI of a table is as given.</p>\n";
}

}  // namespace aula
