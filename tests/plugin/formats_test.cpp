#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/plugin/clap_host.h"
#include "tests/plugin/plugin_host.h"
#include "tests/support/temporary_folder.h"

namespace formats_test {

using namespace aula;
using namespace aula::test;
using plugin::Control;

TEST_CASE("The CLAP plugins give the bytes of the LV2 plugins") {
    const TemporaryFolder folder;
    const std::string file = folder.write("room.json", R"({"aula": 1,
        "geometry": [{"box": [9, 7, 3], "material": "brick"}],
        "sources": [{"name": "s", "position": [6.5, 4.25, 1.5], "signal": "impulse"}],
        "listener": {"position": [3.5, 3.5, 1.5]},
        "simulation": {"rays": 200, "ir_length_s": 0.3}})");
    const std::vector<float> input = noise(1500);
    PluginHost lv2(OutputFormat::toa);
    lv2.restore({{kScene, {LV2_ATOM__Path, {file.c_str(), file.c_str() + file.size() + 1}}}});
    lv2.set_freewheel(1);
    lv2.set(Control::listener_yaw, 30);
    lv2.activate();
    ClapHost clap("aula.room.toa");
    REQUIRE(clap.load("{\"aula_room\": 1, \"scene\": \"" + file + "\"}"));
    clap.set_offline(true);
    clap.set(Control::listener_yaw, 30);
    REQUIRE(clap.activate());
    CHECK((clap.run({input}, {256}) == lv2.run(input, {100})));
}

}  // namespace formats_test
