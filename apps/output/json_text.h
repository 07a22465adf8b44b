#pragma once

#include <string>

#include "engine/input/json.h"

namespace aula {

/// A text as a JSON string, with quotes.
std::string json_string(const std::string& text);

/// A number as JSON: the shortest text that is read back as the same value, independent of the
/// locale.
std::string json_number(float value);
std::string json_number(double value);

/// A value as JSON text: on one line if it fits in 100 columns, else one element per line.
std::string json_text(const JsonValue& value);

/// A value as JSON text on one line.
std::string json_line(const JsonValue& value);

}  // namespace aula
