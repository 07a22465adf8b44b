#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace aula {

/// Length in bytes of the UTF-8 character at `at`, which is in the text; 0 if it is invalid.
std::size_t utf8_length(std::string_view text, std::size_t at);

/// The text if it is UTF-8. Otherwise its bytes are Latin-1, as programs for Windows write them.
std::string utf8_of(std::string_view text);

}  // namespace aula
