#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/live_take.h"
#include "tests/support/realtime_trap.h"
#include "tests/support/test_scenes.h"

using namespace aula;
using namespace aula::test;

TEST_CASE(
    "The audio thread neither allocates, frees, locks nor writes during changes of playback") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    Scene scene = free_field({1, 0, 0});
    scene.simulation.ir_length_s = 0.3F;
    scene.sources[0].loop = true;
    PlaybackOptions options;
    options.output = OutputFormat::mono;
    LiveTake live;
    std::vector<float> channel(kTakeBlock);
    const std::vector<float*> outputs{channel.data()};
    std::vector<std::unique_ptr<PreparedScene>> all;
    RealtimeViolations violations;
    for (int block = 0; block < 400; ++block) {
        if (block % 40 == 0 || (block > 200 && block < 230)) {
            all.push_back(live.prepare(scene, options));
            live.begin(*all.back());
            live.mixer().listen(true);
        }
        if (block == 20) {
            all.back()->playback.signals().publish(std::make_unique<SignalSet>(
                SignalSet{std::make_shared<const Signal>(std::vector<float>(100, 0.1F), true)}));
        }
        live.auralizer().room().set_listener(Pose{});
        const RealtimeTrap trap;
        live.mixer().render(outputs, kTakeBlock);
        violations += trap.violations();
    }
    CHECK(violations.total() == 0);
    CHECK(std::count_if(all.begin(), all.end(), [](const auto& prepared) {
              return prepared->signals[0].use_count() == 1;
          }) > 20);
}
