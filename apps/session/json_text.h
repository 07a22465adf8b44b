#pragma once

#include <string>

namespace aula {

/// A text as a JSON string, with its quotes.
std::string json_string(const std::string& text);

/// A number as JSON, as short as it can be read back to the same float, whatever the locale.
std::string json_number(float value);
std::string json_number(double value);

}  // namespace aula
