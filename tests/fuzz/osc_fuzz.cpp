#include <cmath>
#include <span>

#include "apps/room/remote/adm_osc.h"
#include "apps/room/remote/head_tracker.h"
#include "apps/room/remote/osc.h"
#include "tests/fuzz/fuzz_target.h"

using namespace aula;

namespace {

bool is_finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Objects of ADM-OSC around the origin; whatever a message says, positions stay near them.
void check_adm(const OscMessage& message) {
    Scene scene;
    scene.sources.resize(3);
    AdmOsc adm(scene, {scene, {.adm_radius_m = 5.0F}});
    PlayControls controls;
    for (const OscAnswer& answer : adm.handle(message, controls, {}))
        test::expect(answer.types.size() == answer.message.arguments.size(),
                     "an answer has a type for each argument");
    for (const SourceControl& control : controls.sources) {
        test::expect(!control.position || is_finite(*control.position), "a position is finite");
        test::expect(!control.gain_db || *control.gain_db <= 60, "a gain is at most 60 dB");
    }
    if (!controls.listener) return;
    test::expect(is_finite(controls.listener->position), "the listener's position is finite");
    test::expect(std::isfinite(controls.listener->yaw_rad), "the listener's yaw is finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static OscInput input("0", [](const OscMessage& message) {
        test::expect(message.address.starts_with('/'), "an address begins with a slash");
        for (std::size_t i = 0; i <= message.arguments.size(); ++i) {
            const auto number = message.number(i);
            test::expect(!number || std::isfinite(*number), "a number is finite");
            test::expect(!number || message.text(i) == nullptr, "a number is no text");
        }
        check_adm(message);
        const auto angles_rad = head_angles_rad(message, false);
        test::expect(!angles_rad || is_finite(*angles_rad), "angles of a head are finite");
    });
    input.read(std::as_bytes(std::span(data, size)));
    return 0;
}
