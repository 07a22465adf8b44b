#include "engine/input/text_cursor.h"

#include <algorithm>
#include <charconv>

#include "aula/exception.h"
#include "engine/input/names.h"

namespace aula {
namespace {

bool ends_line(char c) { return c == '\n' || c == '\r'; }

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

}  // namespace

std::string_view TextCursor::word_in_line() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < text_.size() && !is_blank(text_[at_]) && !ends_line(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
}

std::string_view TextCursor::word() {
    while (at_ < text_.size() && (is_blank(text_[at_]) || ends_line(text_[at_]))) ++at_;
    return word_in_line();
}

std::string_view TextCursor::rest_of_line() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    const std::size_t begin = at_;
    while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
    std::size_t end = at_;
    while (end > begin && is_blank(text_[end - 1])) --end;
    return text_.substr(begin, end - begin);
}

void TextCursor::next_line() {
    while (at_ < text_.size() && !ends_line(text_[at_])) ++at_;
    if (text_.substr(at_, 2) == "\r\n") {
        at_ += 2;
    } else if (at_ < text_.size()) {
        ++at_;
    }
}

double TextCursor::number(std::string_view word) const {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    double value = 0;
    const char* end = digits.data() + digits.size();
    const auto [rest, error] = std::from_chars(digits.data(), end, value);
    if (error == std::errc::result_out_of_range) {
        fail("the number " + quoted_start(word) + " is out of range; expected a finite number");
    }
    if (error != std::errc{} || rest != end) {
        fail((word.empty() ? "the line ends" : quoted_start(word)) +
             std::string("; expected a number"));
    }
    return value;
}

void TextCursor::fail(const std::string& problem) const {
    const std::string_view before = text_.substr(0, at_);
    auto line = std::count(before.begin(), before.end(), '\n') + 1;
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (before[i] == '\r' && text_.substr(i + 1, 1) != "\n") ++line;
    }
    throw InputError("line " + std::to_string(line) + ": " + problem);
}

std::string quoted_start(std::string_view word) {
    constexpr std::size_t kLongest = 40;
    return quoted(std::string(word.substr(0, kLongest))) + (word.size() > kLongest ? "..." : "");
}

}  // namespace aula
