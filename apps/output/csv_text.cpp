#include "apps/output/csv_text.h"

namespace aula {

namespace {

bool is_formula(const std::string& text) { return text.find_first_of("=+-@\t\r") == 0; }

}  // namespace

std::string csv_quoted(const std::string& text) {
    std::string quoted = is_formula(text) ? "\"'" : "\"";
    for (const char c : text) {
        if (c == '"') quoted += '"';
        quoted += c;
    }
    return quoted + '"';
}

std::string csv_field(const std::string& text) {
    const bool plain = text.find_first_of(",\"\r\n") == std::string::npos && !is_formula(text);
    return plain ? text : csv_quoted(text);
}

}  // namespace aula
