#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>

#include "apps/room/auralizer/source_register.h"
#include "apps/room/auralizer/source_slots.h"
#include "aula/auralizer.h"
#include "aula/exception.h"
#include "tests/room/auralizer/auralizer_rendering.h"

using namespace aula;
using namespace aula::test;

TEST_CASE("a slot is reused as late as possible") {
    SourceSlots slots(3);
    CHECK(slots.begin({1}) == 0);
    CHECK(slots.begin({2}) == 1);
    CHECK(slots.end({1}) == 0);
    CHECK(slots.begin({3}) == 2);
    CHECK(slots.begin({4}) == 0);
    CHECK(slots.playing() == std::vector<SourceId>{{4}, {2}, {3}});
}

TEST_CASE("as many sources as there may be are present at every time") {
    SourceRegister sources(2);
    const SourceId first = sources.add({0});
    sources.remove(first, {100});
    sources.add({50});
    CHECK_THROWS_AS(sources.add({99}), InputError);
    const SourceId third = sources.add({100});
    // From 20 on there would be three at 100.
    CHECK_THROWS_AS(sources.add({20}), InputError);
    sources.remove(third, {0});
    CHECK(sources.add({200, true}).number > 1000);
    CHECK(sources.sources().size() == 2);
    CHECK(sources.after_beginning(third, {7}) == ChangeTime{100});
    sources.forget(100);
    CHECK(sources.after_beginning(third, {7}) == ChangeTime{7});
}

TEST_CASE("A source that follows a removed one leaves the fade and the reverberation to it") {
    const auto play = [](bool followed) {
        AuralizerOptions options = mono();
        options.max_sources = 1;
        Auralizer auralizer(room_with_panel(), options);
        const SourceId first = auralizer.add_source({.position = {1, 1, 1}}, 0);
        auralizer.remove_source(first, 9001);
        if (followed) auralizer.add_source({.position = {4, 3, 1}}, 9001);
        return rendered(auralizer, 30000, {256}, noise_at, {}, {{2}});
    };
    const std::vector<float> alone = play(false);
    CHECK(std::any_of(alone.begin() + 10000, alone.end(), [](float x) { return x != 0; }));
    CHECK((play(true) == alone));
}

TEST_CASE("A source is not heard through the response of the one before it in its slot") {
    Scene scene = room_with_panel();
    scene.sources = small_room().sources;
    AuralizerOptions options = mono();
    options.max_sources = 1;
    Auralizer auralizer(scene, options);
    auralizer.remove_source(auralizer.sources()[0], 9001);
    auralizer.add_source({.position = {4, 3, 1}}, 9001);
    const std::vector<float> output = rendered(auralizer, 30000, {256}, noise_at, {}, {{1}});
    // Frames begin every 1600 samples: that at 9600 has neither source, the next one the second.
    CHECK(std::all_of(output.begin(), output.begin() + 11200, [](float x) { return x == 0; }));
    CHECK(std::any_of(output.begin() + 11200, output.begin() + 13000,
                      [](float x) { return std::abs(x) > 0.01F; }));
}

TEST_CASE("Sources that before_frame and the caller add do not depend on the timing of threads") {
    const auto play = [](int threads, bool early) {
        Scene scene = room_with_panel();
        scene.simulation.threads = threads;
        AuralizerOptions options = mono();
        options.max_sources = 4;
        std::atomic<int> frame = 0;
        options.before_frame = [&](Auralizer& auralizer, double) {
            if (++frame == 3) auralizer.add_source({.position = {1, 3, 2}});
            if (frame == 4) auralizer.add_source({.position = {3, 3, 2}}, 9000);
        };
        Auralizer auralizer(scene, options);
        auralizer.add_source({.position = {1, 1, 1}}, 0);
        const auto add = [&] { auralizer.add_source({.position = {4, 3, 1}}, 9000); };
        if (early) add();
        return rendered(auralizer, 16000, {256}, noise_at, [&](std::int64_t position) {
            if (!early && position == 8960) add();
        });
    };
    const std::vector<float> reference = play(1, true);
    CHECK((play(1, false) == reference));
    CHECK((play(3, true) == reference));
    CHECK((play(3, false) == reference));
}
