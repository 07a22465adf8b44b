#include "engine/input/names.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <numeric>

namespace aula {
namespace {

bool is_same_letter(char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
}

// Levenshtein distance of a and b, ignoring case.
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (is_same_letter(a[i - 1], b[j - 1]) ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

}  // namespace

std::string quoted(const std::string& name) {
    std::string text = name;
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return '"' + text + '"';
}

std::string quoted_list(const std::vector<std::string>& names) {
    constexpr std::size_t kMax = 100;
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), kMax); ++i) {
        list += (list.empty() ? "" : ", ") + quoted(names[i]);
    }
    if (names.size() > kMax) list += " and " + std::to_string(names.size() - kMax) + " more";
    return list;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates) {
    const std::string meant = nearest_name(name, candidates);
    if (!meant.empty()) return ", did you mean " + quoted(meant) + "?";
    constexpr std::size_t kMax = 3;
    std::vector<std::string> holding;
    for (const std::string& candidate : candidates) {
        if (holding.size() < kMax && !name.empty() && candidate.find(name) != std::string::npos)
            holding.push_back(quoted(candidate));
    }
    if (holding.empty()) return "";
    std::string list = holding[0];
    for (std::size_t i = 1; i < holding.size(); ++i)
        list += (i + 1 < holding.size() ? ", " : " or ") + holding[i];
    return ", did you mean " + list + "?";
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
    constexpr std::size_t kLongest = 64;  // bounds the time for long names
    if (name.size() > kLongest) return {};
    std::string nearest;
    std::size_t min = std::max<std::size_t>(1, name.size() / 3) + 1;
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(name, candidate);
        if (distance < min) {
            min = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

}  // namespace aula
