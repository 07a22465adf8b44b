#include "audio/device/device_list.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "aula/exception.h"

using namespace aula;

namespace {

/// A device of one channel at 48 kHz.
DeviceInfo device(const std::string& name, bool is_default = false, double latency_s = 0) {
    return {0, name, "JACK", 1, 48000, latency_s, is_default};
}

std::vector<std::string> defaults(const std::vector<DeviceInfo>& devices) {
    std::vector<std::string> names;
    for (const DeviceInfo& d : devices) {
        if (d.is_default) names.push_back(d.name);
    }
    return names;
}

std::string refusal(const std::vector<DeviceInfo>& devices, const std::string& wanted) {
    try {
        return "chosen: " + choose_output(devices, wanted).name;
    } catch (const InputError& error) {
        return error.what();
    }
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("JACK ports are grouped by their client, which is named without the colon") {
    CHECK(client_of("system:playback_1") == "system");
    CHECK(client_of("a2j:Synth (capture): port 0") == "a2j");
    // Ports of different clients alternate. "sys" is a part of "system".
    const std::vector<DeviceInfo> devices =
        group_by_client({device("system:playback_1", true, 0.02), device("sys:in", false, 0.01),
                         device("system:playback_2", false, 0.03), device("system:a:b")});
    REQUIRE(devices.size() == 2);
    CHECK(devices[0].name == "system");
    CHECK(devices[0].host_api == "JACK");
    CHECK(devices[0].output_channels == 3);
    CHECK(devices[0].sample_rate_hz == 48000);
    CHECK(devices[0].latency_s == 0.02);
    CHECK(devices[0].is_default);
    CHECK(devices[1].name == "sys");
    CHECK(devices[1].output_channels == 1);
    CHECK(devices[1].latency_s == 0.01);
    CHECK_FALSE(devices[1].is_default);
    CHECK(group_by_client({}).empty());
}

TEST_CASE("Of several default devices the first one is the only default, JACK's before others") {
    const std::vector<DeviceInfo> both =
        merge_outputs({device("effect"), device("card", true), device("second card", true)},
                      {device("pulse", true), device("hw")});
    CHECK(defaults(both) == Names{"card"});
    CHECK(choose_output(both, "").name == "card");
    for (int i = 0; i < 5; ++i) CHECK(both[static_cast<std::size_t>(i)].index == i);
    CHECK(both.back().name == "hw");

    // Without a default of JACK that of the others remains.
    const std::vector<DeviceInfo> other =
        merge_outputs({device("effect")}, {device("hw"), device("pulse", true)});
    CHECK(defaults(other) == Names{"pulse"});
    CHECK(choose_output(other, "").name == "pulse");

    // Without any default the first device is chosen.
    const std::vector<DeviceInfo> none = merge_outputs({}, {device("hw"), device("pulse")});
    CHECK(defaults(none).empty());
    CHECK(choose_output(none, "").name == "hw");
    CHECK_THROWS_AS(choose_output(merge_outputs({}, {}), ""), NoAudioDevice);
}

TEST_CASE("A device is chosen by its index, its name or a part that no other name contains") {
    const std::vector<DeviceInfo> devices =
        merge_outputs({}, {device("Card 2"), device("Card"), device("Pulse")});
    CHECK(choose_output(devices, "2").name == "Pulse");  // an index before a part of a name
    CHECK(choose_output(devices, "PULS").name == "Pulse");
    CHECK(choose_output(devices, "card").name == "Card");  // a name before a part of one
    CHECK(choose_output(devices, "d 2").name == "Card 2");

    const std::string several = refusal(devices, "car");
    CHECK(several.find("matches several outputs") != std::string::npos);
    CHECK(several.find("0 \"Card 2\" (JACK), 1 \"Card\" (JACK)") != std::string::npos);
    CHECK(several.find("Pulse") == std::string::npos);
    const std::string missing = refusal(devices, "3");
    CHECK(missing.find("no such output") != std::string::npos);
    CHECK(missing.find("2 \"Pulse\" (JACK)") != std::string::npos);
}
