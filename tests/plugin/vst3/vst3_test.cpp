#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/plugin/clap_host.h"
#include "tests/plugin/vst3/vst3_host.h"
#include "tests/support/temporary_folder.h"

namespace vst3_test {

namespace {

using namespace aula;
using namespace aula::test;
using plugin::Control;

const std::string kMono = plugin::kKinds[0].id;

/// The state of a small room with few rays.
std::string small_room(const TemporaryFolder& folder) {
    const std::filesystem::path file = folder.write("room.json", R"({"aula": 1,
        "geometry": [{"box": [9, 7, 3], "material": "brick"}],
        "sources": [{"name": "s", "position": [6.5, 4.25, 1.5], "signal": "impulse"}],
        "listener": {"position": [3.5, 3.5, 1.5]},
        "simulation": {"rays": 200, "ir_length_s": 0.3}})");
    return "{\"aula_room\": 1, \"scene\": \"" + file.generic_string() + "\"}";
}

}  // namespace

TEST_CASE("A plugin gives the bytes of the CLAP plugin in blocks of any size") {
    const std::size_t kind = GENERATE(0U, 4U);
    const TemporaryFolder folder;
    const std::string state = small_room(folder);
    Channels input{noise(1200, 1), noise(1200, 2)};
    input.resize(plugin::kKinds[kind].sources);
    // Listener, gain and source at samples that are no multiple of a block.
    ClapHost clap(plugin::kKinds[kind].id);
    REQUIRE(clap.load(state));
    clap.set_offline(true);
    REQUIRE(clap.activate());
    const Channels reference = clap.run(input, {256},
                                        {{101, Control::listener_yaw, 90},
                                         {101, Control::gain_db, -18},
                                         {555, Control::source_room_y, -0.5},
                                         {999, Control::wet, 0.5}});
    REQUIRE(reference.size() == channel_count(plugin::kKinds[kind].output));
    for (const std::size_t size : {1200U, 97U}) {
        INFO("blocks of " << size);
        const Vst3Host vst3(plugin::kKinds[kind].id);
        REQUIRE(vst3.load(state));
        REQUIRE(vst3.set_up(true) == V3_OK);
        REQUIRE(vst3.set_active(true) == V3_OK);
        CHECK((vst3.run(input, size,
                        {{999, Control::wet, 0.5},
                         {101, Control::listener_yaw, 0.75},
                         {555, Control::source_room_y, 0.25},
                         {101, Control::gain_db, 0.5}}) == reference));
    }
}

TEST_CASE("State, parameters and buses, and what cannot be is refused") {
    const TemporaryFolder folder;
    const Vst3Host host(kMono);
    CHECK(host.run({noise(64, 1)}, 64).empty());  // not active
    CHECK(host.set_up(true, 1e9) == V3_OK);
    CHECK(host.set_active(true) == V3_FALSE);
    REQUIRE(host.set_up(true) == V3_OK);
    REQUIRE(host.set_active(true) == V3_OK);
    CHECK(host.set_up(true) == V3_FALSE);
    CHECK(host.run({noise(64, 1)}, 64).size() == 2);

    const auto& controller = *v3_cpp_obj(host.controller());
    REQUIRE(controller.get_parameter_count(host.controller()) == plugin::kControls);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(plugin::kControls); ++i) {
        v3_param_info info;
        REQUIRE(controller.get_parameter_info(host.controller(), i, &info) == V3_OK);
        const v3_param_id id = info.param_id;
        CHECK(controller.get_parameter_normalised(host.controller(), id) ==
              Approx(info.default_normalised_value).margin(1e-6));
        for (const double value : {0.0, info.default_normalised_value, 1.0}) {
            v3_str_128 text;
            double read = -1;
            controller.get_parameter_string_for_value(host.controller(), id, value, text);
            REQUIRE(controller.get_parameter_value_for_string(host.controller(), id, text, &read) ==
                    V3_OK);
            CHECK(read == Approx(value).margin(1e-3));
            CHECK(controller.plain_parameter_to_normalised(
                      host.controller(), id,
                      controller.normalised_parameter_to_plain(host.controller(), id, value)) ==
                  Approx(value).margin(1e-9));
        }
    }
    v3_param_info info;
    CHECK(controller.get_parameter_info(host.controller(), plugin::kControls, &info) != V3_OK);
    CHECK(controller.set_parameter_normalised(host.controller(), 4711, 0.5) != V3_OK);
    CHECK(controller.set_parameter_normalised(host.controller(), 0, 0.75) == V3_OK);

    // Changes in a block without samples, and after the last sample of one.
    const auto wet = static_cast<v3_param_id>(Control::wet);
    host.run({{}}, 64, {{0, Control::wet, 0.25}});
    CHECK(controller.get_parameter_normalised(host.controller(), wet) == Approx(0.25));
    host.run({noise(64, 1)}, 64, {{64, Control::wet, 0.5}});
    CHECK(controller.get_parameter_normalised(host.controller(), wet) == Approx(0.5));

    const std::string state = host.save();
    CHECK(state.find("\"source_x\": 50") != std::string::npos);
    const Vst3Host other(plugin::kKinds[5].id);
    REQUIRE(other.load(state));
    CHECK(other.save() == state);
    CHECK_FALSE(other.load("no state"));
    CHECK_FALSE(other.load(""));
    CHECK(other.save() == state);
    // The CLAP plugins have the same state.
    ClapHost clap("aula.room.toa");
    REQUIRE(clap.load(state));
    CHECK(clap.get(Control::source_x) == 50);

    const auto& processor = *v3_cpp_obj(other.processor());
    v3_speaker_arrangement stereo = V3_SPEAKER_L | V3_SPEAKER_R;
    v3_speaker_arrangement found = 0;
    CHECK(processor.get_bus_arrangement(other.processor(), V3_OUTPUT, 0, &found) == V3_OK);
    CHECK(processor.set_bus_arrangements(other.processor(), &stereo, 1, &found, 1) == V3_TRUE);
    CHECK(processor.set_bus_arrangements(other.processor(), &stereo, 1, &stereo, 1) == V3_FALSE);
    CHECK(processor.get_latency_samples(other.processor()) == 0);
    CHECK(processor.can_process_sample_size(other.processor(), V3_SAMPLE_64) == V3_FALSE);
    void* none = &found;
    CHECK(v3_cpp_obj_query_interface(other.component(), v3_bstream_iid,
                                     reinterpret_cast<void***>(&none)) ==
          static_cast<v3_result>(V3_NO_INTERFACE));
    CHECK(none == nullptr);
}

}  // namespace vst3_test
