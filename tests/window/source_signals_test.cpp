#include "apps/window/model/source_signals.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "aula/audio/sound_file.h"
#include "aula/exception.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace source_signals_test {

using namespace aula;
using namespace aula::test;

namespace {

constexpr double kRate_hz = 48000;

/// Keeps the signal that each of two sources plays.
struct Played {
    std::vector<std::shared_ptr<const Signal>> playing{2};
    SourceSignals signals{kRate_hz, [this](std::size_t source, std::shared_ptr<const Signal> s) {
                              playing[source] = std::move(s);
                          }};

    Played() { signals.restart(2); }

    std::vector<float> samples(std::size_t source, std::size_t count) const {
        std::vector<float> out(count);
        playing[source]->read(0, 0, out);
        return out;
    }
};

}  // namespace

TEST_CASE("A source plays a test signal, then its own again") {
    Played played;
    Scene scene = small_room();
    scene.sources[0].loop = true;
    played.signals.play_test(1, TestSignal::clicks);
    CHECK(played.signals.name(1) == test_signal_name(TestSignal::clicks));
    CHECK(played.signals.name(0).empty());
    CHECK(played.playing[0] == nullptr);
    CHECK(played.samples(1, 8)[0] == 0.5F);

    scene.sources.push_back(scene.sources[0]);
    played.signals.play_own(scene, 1);
    CHECK(played.signals.name(1).empty());
    CHECK(played.samples(1, 8)[0] == 1);  // a unit impulse
}

TEST_CASE("A sound file is repeated, and an unreadable one leaves the signal as it is") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "ramp.wav";
    WavWriter writer(file, kRate_hz, 1, SampleFormat::float32);
    const std::vector<float> ramp{0.1F, 0.2F, 0.3F, 0.4F};
    writer.write(ramp);
    writer.commit();

    Played played;
    played.signals.play_file(0, file);
    CHECK(played.signals.name(0) == "ramp.wav");
    const auto repeated = played.samples(0, 8);
    CHECK(std::equal(ramp.begin(), ramp.end(), repeated.begin() + 4));

    const auto before = played.playing[0];
    CHECK_THROWS_AS(played.signals.play_file(0, folder.path() / "none.wav"), InputError);
    CHECK(played.signals.name(0) == "ramp.wav");
    CHECK(played.playing[0] == before);
}

TEST_CASE("Other sources play the signals of their scene") {
    Played played;
    played.signals.play_test(1, TestSignal::noise);
    played.signals.restart(3);
    CHECK(played.signals.source_count() == 3);
    for (std::size_t source = 0; source < 3; ++source) CHECK(played.signals.name(source).empty());
    CHECK(played.signals.open_microphone() == nullptr);
}

}  // namespace source_signals_test
