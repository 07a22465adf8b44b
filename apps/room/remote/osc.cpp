#include "apps/room/remote/osc.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <lo/lo.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "aula/exception.h"

namespace aula {

namespace {

constexpr const char* kExpected = "a port up to 65535 of this machine, or ADDRESS:PORT";

sockaddr_in parse_address(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    const std::string host = colon == std::string::npos ? "127.0.0.1" : text.substr(0, colon);
    const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
    std::uint16_t number = 0;
    const char* end = port.data() + port.size();
    const auto read = std::from_chars(port.data(), end, number);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (read.ec != std::errc() || read.ptr != end ||
        inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1)
        throw InputError("--osc", "", "\"" + text + "\" is not usable; expected " + kExpected);
    address.sin_port = htons(number);
    return address;
}

/// Creates a UDP socket bound to an address; throws InputError if the address is in use.
int bound_socket(const std::string& address) {
    const sockaddr_in wanted = parse_address(address);
    const int made = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (made >= 0 && bind(made, reinterpret_cast<const sockaddr*>(&wanted), sizeof(wanted)) == 0)
        return made;
    if (made >= 0) close(made);
    throw InputError("--osc", "",
                     "\"" + address + "\" cannot be opened; expected " + std::string(kExpected) +
                         " that is free");
}

int port_of(int socket) {
    sockaddr_in address{};
    socklen_t size = sizeof(address);
    getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
    return ntohs(address.sin_port);
}

/// Reads an argument. Arguments are aligned to 4 bytes only, so a double or lo_arg must be copied.
template <typename T>
T read(const void* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof(value));
    return value;
}

/// An argument in host byte order, as converted by liblo.
std::optional<std::variant<double, std::string>> argument_of(char type, const void* bytes) {
    switch (type) {
        case LO_TRUE:
            return 1.0;
        case LO_FALSE:
            return 0.0;
        case LO_STRING:
        case LO_SYMBOL:
            return std::string(static_cast<const char*>(bytes));
        case LO_INT32:
            return static_cast<double>(read<std::int32_t>(bytes));
        case LO_INT64:
            return static_cast<double>(read<std::int64_t>(bytes));
        case LO_FLOAT:
            return double{read<float>(bytes)};
        case LO_DOUBLE:
            return read<double>(bytes);
        default:
            return std::nullopt;
    }
}

}  // namespace

std::optional<double> OscMessage::number(std::size_t index) const {
    constexpr double kLargest = 1e6;
    if (index >= arguments.size()) return std::nullopt;
    const double* value = std::get_if<double>(&arguments[index]);
    // The comparison also fails for NaN.
    if (value == nullptr || !(std::abs(*value) <= kLargest)) return std::nullopt;
    return *value;
}

std::optional<double> OscMessage::clamped(std::size_t index, double min, double max) const {
    if (index >= arguments.size()) return std::nullopt;
    const double* value = std::get_if<double>(&arguments[index]);
    if (value == nullptr || std::isnan(*value)) return std::nullopt;
    return std::clamp(*value, min, max);
}

const std::string* OscMessage::text(std::size_t index) const {
    return index < arguments.size() ? std::get_if<std::string>(&arguments[index]) : nullptr;
}

void check_osc_address(const std::string& address) { parse_address(address); }

struct OscInput::Server {
    explicit Server(Take on_message) : take(std::move(on_message)) {}
    ~Server() {
        if (lo != nullptr) lo_server_free(lo);
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    /// The callback of liblo for messages of any address. `take` compares addresses, because
    /// liblo's pattern matching can take unbounded time.
    static int pass(const char* path, const char* types, lo_arg** values, int count,
                    lo_message received, void* self) {
        if (path[0] != '/') return 0;
        OscMessage message{.address = path, .arguments = {}, .sender = {}};
        auto& server = *static_cast<Server*>(self);
        const lo_address source = server.receives ? lo_message_get_source(received) : nullptr;
        const char* const host = source != nullptr ? lo_address_get_hostname(source) : nullptr;
        if (host != nullptr) message.sender = host;
        for (int i = 0; i < count; ++i) {
            auto argument = argument_of(types[i], values[i]);
            if (!argument) return 0;
            message.arguments.push_back(std::move(*argument));
        }
        server.take(message);
        return 0;
    }

    Take take;
    lo_server lo = nullptr;
    bool receives = false;  ///< a packet from the network; liblo keeps the address of the last one
    int port = 0;
    std::vector<std::byte> packet;  ///< modified: liblo swaps bytes in place
};

OscInput::OscInput(const std::string& address, Take take)
    : server_(std::make_unique<Server>(std::move(take))) {
    const int bound = bound_socket(address);
    server_->port = port_of(bound);
    server_->lo = lo_server_new_with_proto(nullptr, LO_UDP, [](int, const char*, const char*) {});
    // liblo binds to all interfaces on a port of its choice; the bound socket replaces liblo's.
    const bool replaced =
        server_->lo != nullptr && dup3(bound, lo_server_get_socket_fd(server_->lo), O_CLOEXEC) >= 0;
    close(bound);
    if (!replaced) throw InputError("--osc", "", "UDP is not available; expected a network");
    lo_server_enable_queue(server_->lo, 0, 1);
    lo_server_add_method(server_->lo, nullptr, nullptr, &Server::pass, server_.get());
}

OscInput::~OscInput() = default;

void OscInput::wait(int timeout_ms) {
    server_->receives = true;
    lo_server_recv_noblock(server_->lo, timeout_ms);
    server_->receives = false;
}

void OscInput::read(std::span<const std::byte> packet) {
    server_->packet.assign(packet.begin(), packet.end());
    lo_server_dispatch_data(server_->lo, server_->packet.data(), server_->packet.size());
}

void OscInput::send(const std::string& host, int port, const OscAnswer& answer) {
    const lo_address target = lo_address_new(host.c_str(), std::to_string(port).c_str());
    const lo_message message = lo_message_new();
    for (std::size_t i = 0; i < answer.types.size(); ++i) {
        const auto& argument = answer.message.arguments[i];
        if (answer.types[i] == 's')
            lo_message_add_string(message, std::get<std::string>(argument).c_str());
        else if (answer.types[i] == 'i')
            lo_message_add_int32(message, static_cast<std::int32_t>(std::get<double>(argument)));
        else
            lo_message_add_float(message, static_cast<float>(std::get<double>(argument)));
    }
    lo_send_message_from(target, server_->lo, answer.message.address.c_str(), message);
    lo_message_free(message);
    lo_address_free(target);
}

int OscInput::port() const { return server_->port; }

}  // namespace aula
