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

/// A message of Open Sound Control 1.0: an address and its arguments, numbers of any width as
/// double, true and false as 1 and 0.
struct OscMessage {
    std::string address;
    std::vector<std::variant<double, std::string>> arguments;

    /// An argument that is a finite number no larger than 1e6.
    std::optional<double> number(std::size_t index) const;
    const std::string* text(std::size_t index) const;
};

/// Throws Error if that is neither a port of this machine nor ADDRESS:PORT.
void check_osc_address(const std::string& address);

/// OSC messages over UDP, read by liblo: one at a time to who takes them, those of bundles at once,
/// whatever their time. What is malformed, or has arguments of other kinds, is left out.
/// [one thread]
class OscInput {
 public:
    using Take = std::function<void(const OscMessage&)>;

    /// `address`: a port on this machine alone ("9000"; 0: one that is free), or ADDRESS:PORT.
    /// Throws Error if that is no address or is taken.
    OscInput(const std::string& address, Take take);
    ~OscInput();
    OscInput(const OscInput&) = delete;
    OscInput& operator=(const OscInput&) = delete;

    /// Waits for a packet at most so long, and takes it.
    void wait(int timeout_ms);

    /// Takes a packet as if it had come.
    void read(std::span<const std::byte> packet);

    int port() const;

 private:
    struct Server;
    std::unique_ptr<Server> server_;
};

}  // namespace aula
