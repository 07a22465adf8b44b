#include "apps/session/osc.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <string_view>

using namespace aula;
using namespace std::string_view_literals;

namespace {

std::vector<OscMessage> parse(std::string_view packet) {
    return parse_osc(std::as_bytes(std::span(packet.data(), packet.size())));
}

constexpr auto kPosition =
    "/aula/listener/position\0,fff\0\0\0\0\x3f\x80\0\0\xc0\0\0\0\x3f\0\0\0"sv;
constexpr auto kGain = "/aula/source/gain\0\0\0,si\0voice\0\0\0\xff\xff\xff\xfa"sv;

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

TEST_CASE("A bundle is its messages, in bundles, too") {
    const std::string inner = bundle({kGain});
    const auto messages = parse(bundle({kPosition, inner, kPosition}));
    REQUIRE(messages.size() == 3);
    CHECK(messages[1].address == "/aula/source/gain");
    std::string deep(kGain);
    for (int i = 0; i < 20; ++i) deep = bundle({deep});
    CHECK(parse(deep).empty());
}

TEST_CASE("A malformed packet gives no message") {
    // Cut off anywhere, alone or in a bundle.
    for (const std::string& whole :
         {std::string(kPosition), std::string(kGain), bundle({kGain, kPosition})})
        for (std::size_t size = 0; size < whole.size(); ++size) {
            INFO(size << " of " << whole.size());
            // What is cut between two parts of a bundle is a shorter bundle.
            const auto messages = parse(std::string_view(whole).substr(0, size));
            CHECK((messages.empty() || size == 16 + 4 + kGain.size()));
        }
    CHECK(parse("no address\0\0,\0\0\0"sv).empty());
    CHECK(parse("/a\0\0fff\0"sv).empty());
    CHECK(parse("/a\0\0,b\0\0\0\0\0\4abcd"sv).empty());
    CHECK(parse("/a\0\0,s\0\0unended"sv).empty());
    std::string lying = bundle({kGain});
    lying[16] = '\x7f';
    CHECK(parse(lying).empty());
}

TEST_CASE("Numbers that are none, or too large, are not taken") {
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\xc0\0\0"sv)[0].number(0));  // NaN
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\x80\0\0"sv)[0].number(0));  // infinity
    CHECK_FALSE(parse("/a\0\0,f\0\0\x7f\x00\0\0"sv)[0].number(0));
}

TEST_CASE("Any bytes at all are read without harm") {
    std::mt19937 random(1);
    for (int i = 0; i < 200'000; ++i) {
        std::string packet = i % 2 == 0 ? bundle({kGain, kPosition}) : std::string(kPosition);
        for (int changes = 0; changes < 4; ++changes)
            packet[random() % packet.size()] = static_cast<char>(random() % 256);
        parse(std::string_view(packet).substr(0, random() % (packet.size() + 1)));
    }
    SUCCEED();
}
