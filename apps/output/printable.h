#pragma once

#include <string>
#include <vector>

namespace aula {

/// Escapes control characters except line feeds, directional formatting characters, and bytes that
/// are not UTF-8, as \xNN. Names from files then cannot control a terminal.
std::string printable(const std::string& text);

/// As printable(), with line feeds escaped as well.
std::string printable_line(const std::string& text);
std::vector<std::string> printable_lines(std::vector<std::string> texts);

}  // namespace aula
