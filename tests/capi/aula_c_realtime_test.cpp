#include <catch2/catch.hpp>
#include <vector>

#include "aula.h"
#include "tests/capi/box_room.h"
#include "tests/support/realtime_trap.h"

using namespace aula::test;

TEST_CASE("C: rendering and its errors neither allocate, lock nor write") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    CRoom room(quick_options(AULA_REAL_TIME));
    const aula_source source = room.add_source();
    const std::vector<float> input(300, 0.1F);
    std::vector<float> output(300);
    float* const outputs[] = {output.data()};
    const aula_signal signals[] = {{source, input.data()}, {7, input.data()}, {8, nullptr}};
    RealtimeViolations violations;
    for (int call = 0; call < 200; ++call) {
        const RealtimeTrap trap;
        const int done = aula_room_process(room.handle, signals, 2, outputs, 1, 300);
        const int refused = aula_room_process(room.handle, signals, 3, outputs, 1, 300);
        const char* const message = aula_message();
        violations += trap.violations();
        REQUIRE(done == AULA_OK);
        REQUIRE(refused == AULA_INPUT_ERROR);
        REQUIRE(message[0] != '\0');
    }
    CHECK(violations.total() == 0);
}
