#pragma once

#include <optional>
#include <string>

#include "apps/documents/svg_plot.h"
#include "aula/engine/bands.h"
#include "aula/measurement.h"

namespace aula {

/// A cell with a number, or "-".
std::string number_cell(const std::optional<double>& value, int decimals);

/// A cell with a value and, below it, its standard error. The value has as many decimals as the
/// error has until its first digit, at most `most_decimals`.
std::string value_cell(const MeasuredValue& value, int most_decimals);

/// A cell with a mean over positions and, below it, the number of those that have the value where
/// these are not all.
std::string mean_cell(const MeasuredValue& mean, const MeasuredValue& count, std::size_t positions,
                      int decimals);

/// The head of a table, of header cells; printed again on each page.
std::string head_row(const std::string& cells);

/// A row of a name and a text.
std::string text_row(const std::string& name, const std::string& text);

/// Cells of the octaves: their names, with a star between the end of the modes and the Schroeder
/// frequency, if that is known, and values.
std::string band_headers(const std::optional<double>& schroeder_hz = {}, double waves_below_hz = 0);
std::string band_cells(const Bands& bands, int decimals);

}  // namespace aula
