#include "apps/session/osc.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace aula {

namespace {

constexpr int kDeepest = 8;

/// Reads a packet from its front; every step fails rather than reading on behind the end.
class Reader {
 public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    bool at_end() const { return bytes_.empty(); }

    template <typename T>
    std::optional<T> big_endian() {
        if (bytes_.size() < sizeof(T)) return std::nullopt;
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i)
            value = value << 8 | std::to_integer<std::uint64_t>(bytes_[i]);
        bytes_ = bytes_.subspan(sizeof(T));
        return static_cast<T>(value);
    }

    /// A text, ended by a zero and filled up to four bytes.
    std::optional<std::string> text() {
        std::size_t length = 0;
        while (length < bytes_.size() && bytes_[length] != std::byte{0}) ++length;
        const std::size_t padded = length + 4 - length % 4;
        if (padded > bytes_.size()) return std::nullopt;
        std::string text(reinterpret_cast<const char*>(bytes_.data()), length);
        bytes_ = bytes_.subspan(padded);
        return text;
    }

    std::optional<std::span<const std::byte>> part(std::size_t size) {
        if (size > bytes_.size()) return std::nullopt;
        const auto taken = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return taken;
    }

 private:
    std::span<const std::byte> bytes_;
};

std::optional<std::variant<double, std::string>> read_argument(char type, Reader& reader) {
    using Argument = std::variant<double, std::string>;
    switch (type) {
        case 'i':
            if (const auto bits = reader.big_endian<std::uint32_t>())
                return Argument(static_cast<double>(static_cast<std::int32_t>(*bits)));
            break;
        case 'h':
            if (const auto bits = reader.big_endian<std::uint64_t>())
                return Argument(static_cast<double>(static_cast<std::int64_t>(*bits)));
            break;
        case 'f':
            if (const auto bits = reader.big_endian<std::uint32_t>())
                return Argument(static_cast<double>(std::bit_cast<float>(*bits)));
            break;
        case 'd':
            if (const auto bits = reader.big_endian<std::uint64_t>())
                return Argument(std::bit_cast<double>(*bits));
            break;
        case 's':
        case 'S':
            if (auto text = reader.text()) return Argument(std::move(*text));
            break;
        case 'T':
            return Argument(1.0);
        case 'F':
            return Argument(0.0);
        default:
            break;
    }
    return std::nullopt;
}

std::optional<OscMessage> read_message(Reader& reader) {
    auto address = reader.text();
    if (!address || address->empty() || address->front() != '/') return std::nullopt;
    OscMessage message{std::move(*address), {}};
    const auto types = reader.text();
    if (!types || types->empty() || types->front() != ',') return std::nullopt;
    for (const char type : std::string_view(*types).substr(1)) {
        auto argument = read_argument(type, reader);
        if (!argument) return std::nullopt;
        message.arguments.push_back(std::move(*argument));
    }
    return message;
}

bool read_packet(std::span<const std::byte> packet, int depth, std::vector<OscMessage>& messages) {
    constexpr std::string_view kBundle{"#bundle\0", 8};
    const std::string_view text(reinterpret_cast<const char*>(packet.data()), packet.size());
    Reader reader(packet);
    if (!text.starts_with(kBundle)) {
        auto message = read_message(reader);
        if (!message) return false;
        messages.push_back(std::move(*message));
        return true;
    }
    if (depth == kDeepest || !reader.part(kBundle.size())) return false;
    if (!reader.big_endian<std::uint64_t>()) return false;  // its time: now, for us
    while (!reader.at_end()) {
        const auto size = reader.big_endian<std::uint32_t>();
        const auto part = size ? reader.part(*size) : std::nullopt;
        if (!part || !read_packet(*part, depth + 1, messages)) return false;
    }
    return true;
}

}  // namespace

std::optional<double> OscMessage::number(std::size_t index) const {
    constexpr double kLargest = 1e6;
    if (index >= arguments.size()) return std::nullopt;
    const double* value = std::get_if<double>(&arguments[index]);
    // The comparison fails for NaN, too.
    if (value == nullptr || !(std::abs(*value) <= kLargest)) return std::nullopt;
    return *value;
}

const std::string* OscMessage::text(std::size_t index) const {
    return index < arguments.size() ? std::get_if<std::string>(&arguments[index]) : nullptr;
}

std::vector<OscMessage> parse_osc(std::span<const std::byte> packet) {
    std::vector<OscMessage> messages;
    if (!read_packet(packet, 0, messages)) messages.clear();
    return messages;
}

}  // namespace aula
