#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace aula {

/// Walks through a text word by word. Words are separated by white space; a line ends with \n, \r
/// or \r\n. Valid as long as the text.
class TextCursor {
 public:
    explicit TextCursor(std::string_view text) : text_(text) {}

    bool at_end() const { return at_ == text_.size(); }

    /// The next word of this line, empty at the line's end.
    std::string_view word_in_line();
    /// The next word, on whatever line; empty at the end of the text.
    std::string_view word();
    /// What remains of this line, without white space around it.
    std::string_view rest_of_line();
    /// Goes to the beginning of the next line.
    void next_line();
    /// What remains of the text.
    std::string_view rest() const { return text_.substr(at_); }

    /// The number that a word is, with a decimal point whatever the locale; may be infinite or NaN.
    /// Throws Error for what is no number or beyond the range of double precision.
    double number(std::string_view word) const;

    /// Throws Error "line N: problem", N being the cursor's line.
    [[noreturn]] void fail(const std::string& problem) const;

 private:
    std::string_view text_;
    std::size_t at_ = 0;
};

/// The beginning of a word, in quotes, for an error message.
std::string quoted_start(std::string_view word);

}  // namespace aula
