#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "apps/plugin/plugin_room.h"
#include "tests/plugin/clap_host.h"
#include "tests/plugin/plugin_host.h"
#include "tests/support/temporary_folder.h"

namespace formats_test {

using namespace aula;
using namespace aula::test;
using plugin::Control;

namespace {

/// A small room with few rays.
std::string small_room(const TemporaryFolder& folder) {
    return folder.write("room.json", R"({"aula": 1,
        "geometry": [{"box": [9, 7, 3], "material": "brick"}],
        "sources": [{"name": "s", "position": [6.5, 4.25, 1.5], "signal": "impulse"}],
        "listener": {"position": [3.5, 3.5, 1.5]},
        "simulation": {"rays": 200, "ir_length_s": 0.3}})");
}

StoredState stored(const std::string& file) {
    return {{kScene, {LV2_ATOM__Path, {file.c_str(), file.c_str() + file.size() + 1}}}};
}

}  // namespace

TEST_CASE("The CLAP plugins give the bytes of the LV2 plugins") {
    const TemporaryFolder folder;
    const std::string file = small_room(folder);
    const std::vector<float> input = noise(1500);
    PluginHost lv2(OutputFormat::toa);
    lv2.restore(stored(file));
    lv2.set_freewheel(1);
    lv2.set(Control::listener_yaw, 30);
    // A decimetre from the ends of the room, in metres and as shares of the room.
    lv2.set(Control::source_room_x, 1);
    lv2.set(Control::listener_x, 3.5F);
    lv2.set(Control::listener_y, 0.1F);
    lv2.set(Control::listener_z, 1.5F);
    lv2.activate();
    ClapHost clap("aula.room.toa");
    REQUIRE(clap.load("{\"aula_room\": 1, \"scene\": \"" + file + "\"}"));
    clap.set_offline(true);
    clap.set(Control::listener_yaw, 30);
    clap.set(Control::source_x, 8.9);
    clap.set(Control::source_y, 4.25);
    clap.set(Control::source_z, 1.5);
    clap.set(Control::listener_room_y, -1);
    REQUIRE(clap.activate());
    CHECK((clap.run({input}, {256}) == lv2.run(input, {100})));
}

TEST_CASE("Shares of the room move from the place in metres to the ends of the room") {
    const TemporaryFolder folder;
    const Scene scene = plugin::plugin_scene({.scene = small_room(folder)});
    plugin::ControlValues values = plugin::initial_values();
    const auto set = [&](Control control, float value) {
        values[static_cast<std::size_t>(control)] = value;
    };
    const auto source = [&] {
        return plugin::SceneControls(scene, 1).source_pose(values, 0).position;
    };
    CHECK(source() == Vec3(6.5F, 4.25F, 1.5F));
    set(Control::source_room_x, -0.5F);  // halfway to 0.1 m from the wall at x = 0
    set(Control::source_room_z, 1);
    CHECK(glm::distance(source(), Vec3(3.3F, 4.25F, 2.9F)) < 1e-5F);
    set(Control::source_x, 2.1F);
    set(Control::source_y, 1);
    CHECK(source().x == Approx(1.1F));
    CHECK(source().y == 1);
    // Beyond the wall, whence it comes back but does not go farther away.
    set(Control::source_x, 20);
    set(Control::source_room_x, 1);
    CHECK(source().x == 20);
    set(Control::source_room_x, -1);
    CHECK(source().x == Approx(0.1F));
    set(Control::listener_room_x, 0.5F);
    CHECK(plugin::SceneControls(scene, 1).listener_pose(values).position.x == Approx(6.2F));
    // A place that is wanted is found again; one out of the room is moved to its ends.
    const auto move = [&](const Scene& in, const Vec3& wanted) {
        const plugin::SceneControls controls(in, 1);
        for (const auto& [control, value] : controls.moved_to(wanted, Control::listener_x, values))
            set(control, value);
        return controls.listener_pose(values).position;
    };
    for (const Vec3& wanted : {Vec3(1, 6, 2), Vec3(8.5F, 0.2F, 0.3F), Vec3(3.5F, 3.5F, 1.5F)})
        CHECK(glm::distance(move(scene, wanted), wanted) < 1e-5F);
    CHECK(values[static_cast<std::size_t>(Control::listener_room_x)] == 0);
    CHECK(glm::distance(move(scene, {-5, 3.5F, 50}), Vec3(0.1F, 3.5F, 2.9F)) < 1e-5F);
    CHECK(values[static_cast<std::size_t>(Control::listener_x)] ==
          plugin::initial_values()[static_cast<std::size_t>(Control::listener_x)]);
    // A table of 10 cm has its middle as its ends; a free field has none.
    Scene low = scene;
    low.objects = {};
    values = plugin::initial_values();
    CHECK(plugin::SceneControls(low, 1).listener_pose(values).position.x == 3.5F);
    CHECK(move(low, {-5, 1, 2}) == Vec3(-5, 1, 2));  // in metres
    low.objects.emplace_back().vertices = {{0, 0, 0}, {0.1F, 0, 0}, {0, 1, 0}};
    values = plugin::initial_values();
    set(Control::listener_room_x, -1);
    CHECK(plugin::SceneControls(low, 1).listener_pose(values).position.x == Approx(0.05F));
}

}  // namespace formats_test
