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
    LiveMixer mixer(48000, kTakeBlock, 1);
    mixer.listen(true);
    std::vector<float> channel(kTakeBlock);
    const std::vector<float*> outputs{channel.data()};
    std::vector<std::unique_ptr<PreparedScene>> all;
    RealtimeViolations violations;
    int back = 0;
    for (int block = 0; block < 400; ++block) {
        while (mixer.playbacks().reclaim()) ++back;
        if (block % 40 == 0 || (block > 200 && block < 230)) {
            all.push_back(std::make_unique<PreparedScene>(scene, options, false));
            begin(*all.back(), mixer);
        }
        if (block == 20) {
            all.back()->other_signals.publish(std::make_unique<SignalSet>(
                SignalSet{std::make_shared<const Signal>(std::vector<float>(100, 0.1F), true)}));
        }
        all.back()->auralizer.turn_head(Pose{});
        const RealtimeTrap trap;
        mixer.render(outputs, kTakeBlock);
        violations += trap.violations();
    }
    CHECK(violations.total() == 0);
    CHECK(back > 20);
}
