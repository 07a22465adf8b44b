#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace aula {

/// Reads a text word by word. Words are separated by white space; a line ends with \n, \r or \r\n.
/// The text must outlive the cursor.
class TextCursor {
 public:
    explicit TextCursor(std::string_view text) : text_(text) {}

    bool at_end() const { return at_ == text_.size(); }

    /// The next word of this line; empty at the end of the line.
    std::string_view word_in_line();
    /// The next word of the text; empty at its end.
    std::string_view word();
    /// The rest of this line without leading and trailing white space.
    std::string_view rest_of_line();
    /// Moves to the beginning of the next line.
    void next_line();
    /// The rest of the text.
    std::string_view rest() const { return text_.substr(at_); }

    /// Parses a word as a number with a decimal point, independently of the locale; it may be
    /// infinite or NaN. Throws InputError if it is not a number or out of the range of double
    /// precision.
    double number(std::string_view word) const;

    /// Throws InputError "line N: problem", where N is the present line.
    [[noreturn]] void fail(const std::string& problem) const;

 private:
    std::string_view text_;
    std::size_t at_ = 0;
};

/// The beginning of a word in quotes, for error messages.
std::string quoted_start(std::string_view word);

}  // namespace aula
