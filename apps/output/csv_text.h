#pragma once

#include <string>

namespace aula {

// Texts in cells of CSV files (RFC 4180). A spreadsheet would compute a text that begins with =, +,
// -, @, a tab or a carriage return as a formula: such a text is preceded by an apostrophe.

/// A cell in quotes.
std::string csv_quoted(const std::string& text);

/// A cell, in quotes only if it contains a separator, a quote or a formula.
std::string csv_field(const std::string& text);

}  // namespace aula
