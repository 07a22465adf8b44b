#include "apps/session/osc_remote.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>

#include "engine/error.h"

namespace aula {

namespace {

constexpr const char* kExpected = "a port from 1 to 65535 of this machine, or ADDRESS:PORT";

sockaddr_in parse_address(const std::string& text) {
    const std::size_t colon = text.rfind(':');
    const std::string host = colon == std::string::npos ? "127.0.0.1" : text.substr(0, colon);
    const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
    unsigned number = 0;
    const char* end = port.data() + port.size();
    const auto read = std::from_chars(port.data(), end, number);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (read.ec != std::errc() || read.ptr != end || number < 1 || number > 65535 ||
        inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1)
        throw Error("--osc", "", "\"" + text + "\" is not usable; expected " + kExpected);
    address.sin_port = htons(static_cast<std::uint16_t>(number));
    return address;
}

std::optional<Vec3> point_of(const OscMessage& message, std::size_t first) {
    const auto x = message.number(first);
    const auto y = message.number(first + 1);
    const auto z = message.number(first + 2);
    if (!x || !y || !z) return std::nullopt;
    return Vec3(static_cast<float>(*x), static_cast<float>(*y), static_cast<float>(*z));
}

void turn(Pose& pose, const Vec3& angles_deg) {
    const Vec3 angles_rad = angles_deg * (std::numbers::pi_v<float> / 180);
    pose.yaw_rad = angles_rad.x;
    pose.pitch_rad = angles_rad.y;
    pose.roll_rad = angles_rad.z;
}

}  // namespace

OscRemote::OscRemote(const std::string& address, Player& player,
                     std::vector<std::string> source_names)
    : player_(player), names_(std::move(source_names)) {
    const sockaddr_in wanted = parse_address(address);
    socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 ||
        bind(socket_, reinterpret_cast<const sockaddr*>(&wanted), sizeof(wanted)) != 0) {
        if (socket_ >= 0) close(socket_);
        throw Error("--osc", "",
                    "\"" + address + "\" cannot be listened to; expected " +
                        std::string(kExpected) + " that is free");
    }
    port_ = ntohs(wanted.sin_port);
    thread_ = std::thread([this] { run(); });
}

OscRemote::~OscRemote() {
    stop_ = true;
    thread_.join();
    close(socket_);
}

void OscRemote::run() {
    constexpr int kWait_ms = 50;
    std::vector<std::byte> packet(65536);
    pollfd input{.fd = socket_, .events = POLLIN, .revents = 0};
    while (!stop_) {
        if (poll(&input, 1, kWait_ms) <= 0) continue;
        const ssize_t size = recv(socket_, packet.data(), packet.size(), 0);
        if (size <= 0) continue;
        for (const OscMessage& message :
             parse_osc(std::span(packet).first(static_cast<std::size_t>(size))))
            obey(message);
    }
}

void OscRemote::obey(const OscMessage& message) {
    if (message.address.starts_with("/aula/listener/")) return obey_listener(message);
    if (message.address.starts_with("/aula/source/")) return obey_source(message);
    if (message.address == "/aula/material") {
        const std::string* from = message.text(0);
        const std::string* to = message.text(1);
        if (from == nullptr || to == nullptr) return;
        const std::lock_guard lock(mutex_);
        materials_.emplace_back(*from, *to);
    }
}

void OscRemote::obey_listener(const OscMessage& message) {
    if (message.address == "/aula/listener/path") {
        player_.adjust([](PlayControls& controls, const Pose&) { controls.listener.reset(); });
        return;
    }
    const bool whole = message.address == "/aula/listener/pose";
    const auto position =
        whole || message.address == "/aula/listener/position" ? point_of(message, 0) : std::nullopt;
    const auto angles_deg = whole                                             ? point_of(message, 3)
                            : message.address == "/aula/listener/orientation" ? point_of(message, 0)
                                                                              : std::nullopt;
    if (whole ? !position || !angles_deg : !position && !angles_deg) return;
    player_.adjust([&](PlayControls& controls, const Pose& now) {
        Pose pose = controls.listener.value_or(now);
        if (position) pose.position = *position;
        if (angles_deg) turn(pose, *angles_deg);
        controls.listener = pose;
    });
}

void OscRemote::obey_source(const OscMessage& message) {
    const std::string* name = message.text(0);
    if (name == nullptr) return;
    std::size_t source = 0;
    {
        const std::lock_guard lock(mutex_);
        source = static_cast<std::size_t>(std::find(names_.begin(), names_.end(), *name) -
                                          names_.begin());
        if (source == names_.size()) return;
    }
    player_.adjust([&](PlayControls& controls, const Pose&) {
        if (controls.sources.size() <= source) controls.sources.resize(source + 1);
        SourceControl& control = controls.sources[source];
        if (message.address == "/aula/source/position") {
            if (const auto position = point_of(message, 1)) control.position = position;
        } else if (message.address == "/aula/source/gain") {
            constexpr double kMost_db = 60;
            if (const auto gain_db = message.number(1); gain_db && *gain_db <= kMost_db)
                control.gain_db = static_cast<float>(*gain_db);
        } else if (message.address == "/aula/source/mute") {
            if (const auto muted = message.number(1)) control.muted = *muted != 0;
        }
    });
}

void OscRemote::set_sources(std::vector<std::string> names) {
    const std::lock_guard lock(mutex_);
    names_ = std::move(names);
}

std::vector<std::pair<std::string, std::string>> OscRemote::take_materials() {
    const std::lock_guard lock(mutex_);
    return std::exchange(materials_, {});
}

}  // namespace aula
