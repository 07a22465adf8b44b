#include "apps/room/remote/osc.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <string_view>

#include "apps/room/remote/adm_osc.h"
#include "apps/room/remote/head_tracker.h"
#include "aula/exception.h"

using namespace aula;
using namespace std::string_view_literals;

namespace {

/// An input on a free port, and the messages that it received.
class Input {
 public:
    std::vector<OscMessage> parse(std::string_view packet) {
        messages_.clear();
        input_.read(std::as_bytes(std::span(packet.data(), packet.size())));
        return std::move(messages_);
    }
    std::vector<OscMessage> wait() {
        messages_.clear();
        input_.wait(5000);
        return std::move(messages_);
    }
    int port() const { return input_.port(); }

 private:
    std::vector<OscMessage> messages_;
    OscInput input_{"0", [this](const OscMessage& message) { messages_.push_back(message); }};
};

std::vector<OscMessage> parse(std::string_view packet) { return Input().parse(packet); }

constexpr auto kPosition =
    "/aula/listener/position\0,fff\0\0\0\0\x3f\x80\0\0\xc0\0\0\0\x3f\0\0\0"sv;
constexpr auto kGain = "/aula/source/gain\0\0\0,si\0voice\0\0\0\xff\xff\xff\xfa"sv;

constexpr auto kAdmPosition = "/adm/obj/2/xyz\0\0,fff\0\0\0\0\x3f\x80\0\0\xbf\0\0\0\x3e\x80\0\0"sv;
constexpr auto kAdmQuery = "/adm/obj/*/aed\0\0,\0\0\0"sv;
constexpr auto kAdmGain = "/adm/obj/[1-2]/gain\0,f\0\0\x3f\0\0\0"sv;
constexpr auto kQuaternion =
    "/SceneRotator/quaternions\0\0\0,ffff\0\0\0\x3f\x35\x04\xf3\0\0\0\0\0\0\0\0\x3f\x35\x04\xf3"sv;

std::string bundle(std::initializer_list<std::string_view> parts) {
    std::string packet("#bundle\0\0\0\0\0\0\0\0\1", 16);
    for (const std::string_view part : parts) {
        packet += std::string(2, '\0');
        packet += static_cast<char>(part.size() / 256);
        packet += static_cast<char>(part.size() % 256);
        packet += part;
    }
    return packet;
}

}  // namespace

TEST_CASE("An OSC message is its address and its arguments") {
    const auto position = parse(kPosition);
    REQUIRE(position.size() == 1);
    CHECK(position[0].address == "/aula/listener/position");
    CHECK(position[0].number(0) == 1.0);
    CHECK(position[0].number(1) == -2.0);
    CHECK(position[0].number(2) == 0.5);
    CHECK_FALSE(position[0].number(3));
    const auto gain = parse(kGain);
    REQUIRE(gain.size() == 1);
    REQUIRE(gain[0].text(0) != nullptr);
    CHECK(*gain[0].text(0) == "voice");
    CHECK(gain[0].number(1) == -6.0);
    CHECK(gain[0].text(1) == nullptr);
    const auto switches = parse("/a\0\0,TFdh\0\0\0\x3f\xf8\0\0\0\0\0\0\0\0\0\0\0\0\0\7"sv);
    REQUIRE(switches.size() == 1);
    CHECK(switches[0].number(0) == 1.0);
    CHECK(switches[0].number(1) == 0.0);
    CHECK(switches[0].number(2) == 1.5);
    CHECK(switches[0].number(3) == 7.0);
}

TEST_CASE(
    "A bundle gives its messages, also those of inner bundles, immediately for any time tag") {
    const std::string inner = bundle({kGain});
    const auto messages = parse(bundle({kPosition, inner, kPosition}));
    REQUIRE(messages.size() == 3);
    CHECK(messages[1].address == "/aula/source/gain");
    std::string later = bundle({kGain});
    later[8] = '\x7f';  // a date in the far future
    CHECK(parse(later).size() == 1);
}

TEST_CASE("A bundle nested as deeply as a packet allows does no harm") {
    std::string deep(kGain);
    while (deep.size() < 60'000) deep = bundle({deep});
    Input input;
    input.parse(deep);
    CHECK(input.parse(kGain).size() == 1);
}

TEST_CASE("A truncated message is ignored") {
    for (const std::string_view whole : {kPosition, kGain})
        for (std::size_t size = 0; size < whole.size(); ++size) {
            INFO(size << " of " << whole.size());
            CHECK(parse(whole.substr(0, size)).empty());
        }
    CHECK(parse("no address\0\0,\0\0\0"sv).empty());
    CHECK(parse("/a\0\0fff\0"sv).empty());
    CHECK(parse("/a\0\0,b\0\0\0\0\0\4abcd"sv).empty());
    CHECK(parse("/a\0\0,s\0\0unended"sv).empty());
    std::string corrupt = bundle({kGain});
    corrupt[16] = '\x7f';
    CHECK(parse(corrupt).empty());
}

TEST_CASE("Of a truncated bundle only complete messages are accepted") {
    const std::string whole = bundle({kGain, kPosition});
    for (std::size_t size = 0; size < whole.size(); ++size) {
        INFO(size << " of " << whole.size());
        const auto messages = parse(std::string_view(whole).substr(0, size));
        CHECK(messages.size() <= 1);
        for (const OscMessage& message : messages) CHECK(message.number(1) == -6.0);
    }
}

TEST_CASE("OSC is received from this machine only unless requested otherwise, on a free port") {
    Input input;
    const int sender = socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(input.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(sendto(sender, kGain.data(), kGain.size(), 0,
                   reinterpret_cast<const sockaddr*>(&address), sizeof(address)) > 0);
    close(sender);
    CHECK(input.wait().size() == 1);
    // The kernel's table lists bound sockets in hexadecimal digits: 127.0.0.1, a port.
    std::ifstream table("/proc/net/udp");
    const std::string bound((std::istreambuf_iterator<char>(table)), {});
    std::array<char, 16> port{};
    std::snprintf(port.data(), port.size(), ":%04X ", input.port());
    CHECK(bound.find(std::string("0100007F") + port.data()) != std::string::npos);
    CHECK(bound.find(std::string("00000000") + port.data()) == std::string::npos);
    CHECK_THROWS_AS(OscInput(std::to_string(input.port()), [](const OscMessage&) {}), InputError);
    for (const char* wrong : {"", "x", "65536", "-1", "1.2.3:9000", "host:9000", "9000 "})
        CHECK_THROWS_AS(OscInput(wrong, [](const OscMessage&) {}), InputError);
}

TEST_CASE("A message has its sender's address, and is answered to a port of it") {
    std::vector<OscMessage> messages;
    OscInput input("0", [&](const OscMessage& message) { messages.push_back(message); });
    OscInput sender("127.0.0.9:0", [&](const OscMessage& message) { messages.push_back(message); });
    sender.send("127.0.0.1", input.port(), {{"/adm/obj/1/xyz", {}}, ""});
    input.wait(5000);
    REQUIRE(messages.size() == 1);
    CHECK(messages[0].address == "/adm/obj/1/xyz");
    CHECK(messages[0].arguments.empty());
    CHECK(messages[0].sender == "127.0.0.9");
    input.send(messages[0].sender, sender.port(), {{"/x", {0.5, 1.0, "name"}}, "fis"});
    sender.wait(5000);
    REQUIRE(messages.size() == 2);
    CHECK(messages[1].sender == "127.0.0.1");
    CHECK(messages[1].number(0) == 0.5);
    CHECK(messages[1].number(1) == 1.0);
    CHECK(*messages[1].text(2) == "name");
    input.read(std::as_bytes(std::span(kGain.data(), kGain.size())));
    CHECK(messages[2].sender.empty());
}

TEST_CASE("Numbers that are not finite or too large are ignored") {
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\xc0\0\0"sv)[0].number(0));  // NaN
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\x80\0\0"sv)[0].number(0));  // infinity
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\x00\0\0"sv)[0].number(0));
}

TEST_CASE("Arbitrary bytes are read without harm") {
    std::mt19937 random(1);
    Scene scene;
    scene.sources.resize(3);
    AdmOsc adm(scene, {scene, {}});
    PlayControls controls;
    std::size_t taken = 0;
    std::size_t answered = 0;
    OscInput input("0", [&](const OscMessage& message) {
        ++taken;
        answered += adm.handle(message, controls, {}).size();
        head_angles_rad(message, false);
    });
    const std::array<std::string, 5> packets{
        bundle({kGain, kPosition}), std::string(kPosition), std::string(kAdmPosition),
        bundle({kAdmQuery, kAdmGain}), std::string(kQuaternion)};
    for (int i = 0; i < 1'000'000; ++i) {
        std::string packet = packets[static_cast<std::size_t>(i) % packets.size()];
        for (int changes = 0; changes < 4; ++changes)
            packet[random() % packet.size()] = static_cast<char>(random() % 256);
        // Half of them are truncated.
        const std::size_t size = i % 4 < 2 ? packet.size() : random() % (packet.size() + 1);
        input.read(std::as_bytes(std::span(packet).first(size)));
    }
    CHECK(taken > 50'000);
    CHECK(answered > 1000);
    taken = 0;
    input.read(std::as_bytes(std::span(kGain.data(), kGain.size())));
    CHECK(taken == 1);
}
