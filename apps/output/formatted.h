#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace aula {

/// Formats a line of text like printf, truncated to 255 characters.
template <typename... Values>
std::string formatted(const char* format, Values... values) {
    std::array<char, 256> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

/// A number with a fixed number of decimals, as wide as `width` at least. No negative zero: -0.01
/// with one decimal is "0.0".
inline std::string fixed_text(double value, int decimals, int width = 0) {
    std::string text = formatted("%*.*f", width, decimals, value);
    if (!std::isfinite(value) || text.find_first_of("123456789") != std::string::npos) return text;
    return formatted("%*.*f", width, decimals, 0.0);
}

/// A number of things: "1 item", "2 items".
inline std::string counted(std::uint64_t count, const char* what) {
    return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// The message for samples that an Auralizer or a file has muted.
inline std::string muted_text(std::int64_t samples) {
    return std::to_string(samples) + " samples were not finite, or beyond 1e6, and were muted";
}

/// Of a player: how many of its sources do not reach the listener, and why that may be.
inline std::string silent_text(std::size_t silent, std::size_t sources) {
    if (silent == 0) return "sound of each source reaches the listener";
    const std::string why =
        " the listener, for instance from outside of the room, out of an object or through walls "
        "that transmit nothing";
    if (silent == sources) return "no sound reaches" + why;
    return "nothing of " + std::to_string(silent) + " of " + std::to_string(sources) +
           " sources reaches" + why;
}

}  // namespace aula
