#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace aula {

/// A message of Open Sound Control 1.0: an address and its arguments, numbers of any width as
/// double, true and false as 1 and 0.
struct OscMessage {
    std::string address;
    std::vector<std::variant<double, std::string>> arguments;

    /// An argument that is a finite number no larger than 1e6.
    std::optional<double> number(std::size_t index) const;
    const std::string* text(std::size_t index) const;
};

/// The messages of a packet, those of bundles in their order and at once, whatever their time. A
/// packet that is cut short, nested deeper than 8 or otherwise wrong gives none.
std::vector<OscMessage> parse_osc(std::span<const std::byte> packet);

}  // namespace aula
