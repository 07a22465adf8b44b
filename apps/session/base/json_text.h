#pragma once

#include <string>

#include "engine/input/json.h"

namespace aula {

/// A text as a JSON string, with its quotes.
std::string json_string(const std::string& text);

/// A number as JSON, as short as it can be read back to the same float, whatever the locale.
std::string json_number(float value);
std::string json_number(double value);

/// A value as JSON text: what fits stands on one line of 100 columns, else one element a line.
std::string json_text(const JsonValue& value);

}  // namespace aula
