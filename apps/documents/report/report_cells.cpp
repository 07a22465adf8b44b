#include "apps/documents/report/report_cells.h"

#include <algorithm>
#include <cmath>

#include "apps/output/formatted.h"
#include "apps/room/offline/measurement_text.h"

namespace aula {

namespace {

std::string number_or_dash(const std::optional<double>& value, int decimals) {
    return value && std::isfinite(*value) ? fixed_text(*value, decimals) : "-";
}

/// Decimals of a value: as many as its standard error has until its first digit, at most `most`.
int certain_decimals(const MeasuredValue& value, int most) {
    const double error = value.standard_error.value_or(0);
    if (!(error > 0)) return most;
    return std::clamp(static_cast<int>(std::ceil(-std::log10(error))), 0, most);
}

std::string small(const std::string& text) { return "<small>" + text + "</small>"; }

}  // namespace

std::string number_cell(const std::optional<double>& value, int decimals) {
    return html_cell(number_or_dash(value, decimals));
}

std::string value_cell(const MeasuredValue& value, int most_decimals) {
    const int decimals = certain_decimals(value, most_decimals);
    std::string cell = "<td>" + number_or_dash(value.value, decimals);
    if (value.value && value.standard_error) {
        const double digit = std::pow(10, -decimals);
        const bool is_small = *value.standard_error < 0.5 * digit;
        cell += small(is_small ? "&lt; " + fixed_text(digit, decimals)
                               : "± " + fixed_text(*value.standard_error, decimals));
    }
    return cell + "</td>";
}

std::string mean_cell(const MeasuredValue& mean, const MeasuredValue& count, std::size_t positions,
                      int decimals) {
    std::string cell = "<td>" + number_or_dash(mean.value, decimals);
    if (count.value && *count.value < static_cast<double>(positions))
        cell += small(formatted("%.0f of %zu", *count.value, positions));
    return cell + "</td>";
}

std::string head_row(const std::string& cells) {
    return "<thead>" + html_row(cells) + "</thead>\n";
}

std::string text_row(const std::string& name, const std::string& text) {
    return html_row(html_cell(name) + html_cell(text));
}

std::string band_headers(const std::optional<double>& schroeder_hz, double waves_below_hz) {
    std::string cells;
    for (std::size_t band = 0; band < kBandCount; ++band) {
        const double centre_hz{kBandCentres_hz[band]};
        const bool is_marked =
            schroeder_hz && centre_hz < *schroeder_hz && centre_hz >= waves_below_hz;
        cells += html_header(band_name(band) + (is_marked ? " *" : ""));
    }
    return cells;
}

std::string band_cells(const Bands& bands, int decimals) {
    std::string cells;
    for (const float value : bands.value)
        cells += number_cell(static_cast<double>(value), decimals);
    return cells;
}

}  // namespace aula
