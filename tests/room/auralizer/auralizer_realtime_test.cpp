#include <algorithm>
#include <catch2/catch.hpp>

#include "aula/audio/sound_file.h"
#include "aula/auralizer.h"
#include "tests/support/realtime_trap.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

using namespace aula;
using namespace aula::test;

TEST_CASE(
    "An auralizer neither allocates, frees, locks nor writes in render() while everything "
    "changes") {
    if (!RealtimeTrap::available()) {
        WARN("skipped: sanitizers own these functions");
        return;
    }
    Scene scene = small_room();
    scene.simulation.rays = 50;
    scene.objects[0].movable = true;
    AuralizerOptions options;
    options.listeners = 2;
    options.max_sources = 3;
    const TemporaryFolder folder;
    options.headphones = folder.path() / "headphones.wav";
    WavWriter writer(options.headphones, 48000, 1, SampleFormat::float32);
    writer.write(std::vector<float>(3000, 1e-3F));
    writer.commit();
    Auralizer auralizer(scene, options);
    std::vector<float> input(600, 0.1F);
    std::vector<std::vector<float>> channels(auralizer.output_channels(),
                                             std::vector<float>(input.size()));
    std::vector<float*> outputs;
    for (auto& channel : channels) outputs.push_back(channel.data());
    std::vector<SourceSignal> inputs;
    for (std::uint64_t number = 1; number < 8; ++number) inputs.push_back({{number}, input.data()});
    RealtimeViolations violations;
    SourceId added;
    bool audible = false;
    for (int call = 0; call < 600 || auralizer.status().frames < 8; ++call) {
        Pose pose;
        pose.position = {3, 2, 1.0F + 0.001F * static_cast<float>(call % 100)};
        pose.yaw_rad = 0.01F * static_cast<float>(call);
        auralizer.set_listener(static_cast<std::size_t>(call % 2), pose);
        if (call % 100 == 10) added = auralizer.add_source({.position = {2, 2, 1}});
        if (call % 100 == 60) auralizer.remove_source(added);
        if (call % 100 == 20) auralizer.set_material(0, "curtain");
        if (call % 100 == 30) auralizer.set_transform(0, RigidTransform(Pose{}));
        if (call % 100 == 70) auralizer.pause();
        if (call % 100 == 80) auralizer.resume();
        const int samples = call % 3 == 0 ? 600 : call % 3 == 1 ? 17 : 256;
        const RealtimeTrap trap;
        auralizer.render(inputs, outputs, samples);
        violations += trap.violations();
        audible |= std::any_of(channels[0].begin(), channels[0].begin() + samples,
                               [](float x) { return x != 0; });
    }
    CHECK(violations.total() == 0);
    CHECK(audible);
}
