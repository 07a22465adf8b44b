#include "engine/input/json.h"

#include <algorithm>
#include <cassert>
#include <cctype>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <unordered_set>

#include "aula/exception.h"
#include "engine/input/names.h"

namespace aula {
namespace {

constexpr std::size_t kDeepest = 100;
constexpr std::size_t kMaxValues = 10'000'000;  // bounds memory: half a gigabyte

// The word (letters and signs) around an offset, such as "NaN".
std::string_view word_at(std::string_view text, std::size_t offset) {
    const auto in_word = [&](std::size_t i) {
        const auto c = static_cast<unsigned char>(text[i]);
        return std::isalpha(c) != 0 || c == '-' || c == '+' || c == '_';
    };
    std::size_t begin = std::min(offset, text.size());
    while (begin > 0 && in_word(begin - 1)) --begin;
    std::size_t end = begin;
    while (end < text.size() && in_word(end)) ++end;
    return text.substr(begin, end - begin);
}

// Whether a word denotes a non-finite number, which JSON lacks: "NaN", "-Infinity", "inf".
bool is_non_finite(std::string word) {
    if (!word.empty() && (word[0] == '-' || word[0] == '+')) word.erase(0, 1);
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return word == "nan" || word == "inf" || word == "infinity";
}

// Describes the text at an offset that is not valid JSON.
std::string found_at(std::string_view text, std::size_t offset) {
    constexpr std::size_t kLongest = 40;
    std::string_view found = word_at(text, offset).substr(0, kLongest);
    if (found.empty()) {
        if (offset >= text.size()) return "the end of the text";
        constexpr std::size_t kLongestCharacter = 4;  // in UTF-8
        std::size_t end = offset + 1;
        while (end < std::min(text.size(), offset + kLongestCharacter) &&
               (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) {
            ++end;
        }
        found = text.substr(offset, end - offset);
    }
    return quoted(std::string(found));
}

// A part of the parser's messages and its meaning.
struct Meaning {
    const char* part;
    const char* meaning;
};

// The meaning of the first part that the message contains; null if there is none.
const char* meaning_of(const std::string& message, std::span<const Meaning> meanings) {
    for (const Meaning& m : meanings) {
        if (message.find(m.part) != std::string::npos) return m.meaning;
    }
    return nullptr;
}

constexpr Meaning kFound[] = {
    {"missing closing quote", "a string without its closing quote"},
    {"must be escaped", "a control character in a string"},
    {"after backslash", "an unknown escape in a string"},
    {"hex digits", "an unfinished \\u escape in a string"},
    {"surrogate", "half of a surrogate pair in a string"},
    {"UTF-8", "a byte that is not UTF-8"},
    {"invalid BOM", "an unknown byte order mark"},
    {"missing closing '*/'", "a comment without its end"},
    {"invalid comment", "a comment that begins with neither // nor /*"},
    {"invalid number", "an unfinished number"},
    {"unexpected string literal", "a string"},
    {"unexpected number literal", "a number"},
    {"unexpected true literal", "true"},
    {"unexpected false literal", "false"},
    {"unexpected null literal", "null"},
    {"unexpected end of input", "the end of the text"},
    {"empty input", "the end of the text"},
};

constexpr Meaning kExpected[] = {
    {"parsing object key", "a key in double quotes"},
    {"parsing object separator", "':'"},
    {"parsing object", "',' or '}'"},
    {"parsing array", "',' or ']'"},
    {"; expected end of input", "the end of the text"},
    {"parsing value", "a value"},
    {"empty input", "a value"},
};

// "line L, column C" of a byte offset, both counted from 1.
std::string line_and_column(const std::string& text, std::size_t offset) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text.size()));
    const auto line = std::count(text.begin(), end, '\n') + 1;
    auto line_begin = end;
    while (line_begin != text.begin() && *(line_begin - 1) != '\n') --line_begin;
    return "line " + std::to_string(line) + ", column " + std::to_string(end - line_begin + 1);
}

// Builds the value from the parser's events and tracks the position as a JSON pointer.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
    Builder(const std::string& text, const std::string& file) : text_(text), file_(file) {}

    JsonValue take() { return std::move(root_); }

    bool null() override { return add(std::monostate{}); }
    bool boolean(bool x) override { return add(x); }
    bool number_integer(number_integer_t x) override { return add(static_cast<double>(x)); }
    bool number_unsigned(number_unsigned_t x) override { return add(std::uint64_t{x}); }
    bool number_float(number_float_t x, const string_t&) override { return add(x); }
    bool string(string_t& x) override { return add(std::move(x)); }
    bool binary(binary_t&) override { return false; }  // not in JSON text
    bool start_object(std::size_t) override { return open(JsonValue::Object{}); }
    bool start_array(std::size_t) override { return open(JsonValue::Array{}); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override {
        auto& members = std::get<JsonValue::Object>(open_.back().container->value);
        open_.back().key = name;
        const bool added = open_.back().keys.insert(name).second;
        if (!added) throw InputError(file_, pointer(), "duplicate key; expected each key once");
        members.emplace_back().key = std::move(name);
        return true;
    }

    bool parse_error(std::size_t position, const std::string& token,
                     const nlohmann::json::exception& error) override {
        constexpr int kNumberOverflow = 406;
        if (error.id == kNumberOverflow) {
            throw InputError(file_, pointer(),
                             "the number " + token + " is too large; expected a finite number");
        }
        // `position` counts the characters read, including the offending one.
        const std::size_t offset = position > 0 ? position - 1 : 0;
        const std::string_view word = word_at(text_, offset);
        if (is_non_finite(std::string(word))) {
            throw InputError(file_, pointer(),
                             std::string(word) + " is not a JSON number; expected a finite number");
        }
        // Without the text read last, which is part of the file.
        const std::string whole = error.what();
        const std::string message = whole.substr(0, whole.find("; last read"));
        const char* const found = meaning_of(message, kFound);
        const char* const expected = meaning_of(message, kExpected);
        // `token` is the exact text of an unexpected string or number. An unknown word begins
        // before the character at which the parser stops.
        std::size_t start = offset;
        if (found == nullptr && !word.empty()) {
            start = static_cast<std::size_t>(word.data() - text_.data());
        } else if (message.find("unexpected string literal") != std::string::npos ||
                   message.find("unexpected number literal") != std::string::npos) {
            start = offset + 1 - std::min(token.size(), offset);
        }
        throw InputError(file_, line_and_column(text_, start),
                         std::string("found ") +
                             (found != nullptr ? found : found_at(text_, offset)) + "; expected " +
                             (expected != nullptr ? expected : "JSON"));
    }

 private:
    struct Open {
        JsonValue* container;
        std::size_t index = 0;                 // of the element being read, in an array
        std::string key;                       // of the member being read, in an object
        std::unordered_set<std::string> keys;  // of the object so far
    };

    std::string pointer() const {
        std::string pointer;
        for (const Open& open : open_) {
            const bool array = std::holds_alternative<JsonValue::Array>(open.container->value);
            pointer = json_pointer(pointer, array ? std::to_string(open.index) : open.key);
        }
        return pointer;
    }

    // The node of the next value.
    JsonValue& slot() {
        if (++value_count_ > kMaxValues) {
            throw InputError(file_, pointer(),
                             "too many values; expected at most " + std::to_string(kMaxValues));
        }
        if (open_.empty()) return root_;
        JsonValue& container = *open_.back().container;
        if (auto* array = std::get_if<JsonValue::Array>(&container.value)) {
            return array->emplace_back();
        }
        return std::get<JsonValue::Object>(container.value).back().value;
    }

    template <class T>
    bool add(T&& x) {
        slot().value = std::forward<T>(x);
        if (!open_.empty()) ++open_.back().index;
        return true;
    }

    template <class Container>
    bool open(Container&& container) {
        if (open_.size() == kDeepest) {
            throw InputError(
                file_, pointer(),
                "nested too deeply; expected at most " + std::to_string(kDeepest) + " levels");
        }
        // Stable: the vector that contains an open container does not grow before it is closed.
        JsonValue& node = slot();
        node.value = std::forward<Container>(container);
        open_.push_back({&node, 0, {}, {}});
        return true;
    }

    bool close() {
        open_.pop_back();
        if (!open_.empty()) ++open_.back().index;
        return true;
    }

    const std::string& text_;
    const std::string& file_;
    JsonValue root_;
    std::vector<Open> open_;
    std::size_t value_count_ = 0;
};

}  // namespace

std::string json_pointer(const std::string& parent, const std::string& key) {
    std::string pointer = parent + '/';
    for (const char c : key) {
        if (c == '~') {
            pointer += "~0";
        } else if (c == '/') {
            pointer += "~1";
        } else {
            pointer += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
        }
    }
    return pointer;
}

JsonValue parse_json(const std::string& text, const std::string& file) {
    constexpr bool kWholeText = true;
    constexpr bool kComments = true;
    // The parser would treat NUL as the end of the text.
    if (const std::size_t nul = text.find('\0'); nul != std::string::npos) {
        throw InputError(file, line_and_column(text, nul), "a NUL byte; expected text");
    }
    Builder builder(text, file);
    nlohmann::json::sax_parse(text, &builder, nlohmann::json::input_format_t::json, kWholeText,
                              kComments);
    return builder.take();
}

}  // namespace aula
