#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace aula {

/// A message of Open Sound Control 1.0: an address and its arguments. Numbers of any width are
/// double, true and false are 1 and 0.
struct OscMessage {
    std::string address;
    std::vector<std::variant<double, std::string>> arguments{};
    std::string sender{};  ///< numeric address of the host that sent it; empty: unknown

    /// The argument at `index`, if it is a finite number of at most 1e6 in magnitude.
    std::optional<double> number(std::size_t index) const;
    const std::string* text(std::size_t index) const;

    /// The number at `index`, clamped to a range; empty if it is none or not a number.
    std::optional<double> clamped(std::size_t index, double min, double max) const;
};

/// A message to send, with the OSC types of its arguments: 'f' (float), 'i' (int32) or 's'
/// (string).
struct OscAnswer {
    OscMessage message;
    std::string types;
};

/// Throws InputError if the text is neither a port of this machine nor ADDRESS:PORT.
void check_osc_address(const std::string& address);

/// Receives OSC messages over UDP by liblo and passes them on one at a time. Messages of bundles
/// are passed on immediately, whatever their time tag. Malformed messages and those with arguments
/// of other types are ignored. [one thread]
class OscInput {
 public:
    using Take = std::function<void(const OscMessage&)>;

    /// `address`: a port on this machine alone ("9000"; 0: a free one), or ADDRESS:PORT. Throws
    /// InputError if the address is invalid or in use.
    OscInput(const std::string& address, Take take);
    ~OscInput();
    OscInput(const OscInput&) = delete;
    OscInput& operator=(const OscInput&) = delete;

    /// Waits for a packet for at most `timeout_ms`, and processes it.
    void wait(int timeout_ms);

    /// Processes a packet as if it had been received.
    void read(std::span<const std::byte> packet);

    /// Sends a message to a port of the host with a numeric address.
    void send(const std::string& host, int port, const OscAnswer& answer);

    int port() const;

 private:
    struct Server;
    std::unique_ptr<Server> server_;
};

}  // namespace aula
