#include "apps/room/live/change_preparer.h"

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "aula/devices/scene_player.h"
#include "aula/exception.h"
#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

using namespace aula;

namespace {

/// A preparer whose changes begin by a function of the test, and which notes how they begin.
class Preparation {
 public:
    using Begin = std::function<void(Preparation&, std::uint64_t number)>;

    explicit Preparation(Begin begin)
        : changes_(48000,
                   {.reusable = [] { return Reusable{}; },
                    .state = [](const PreparedScene& prepared) { return prepared.state({}, 0); },
                    .begin =
                        [this, begin = std::move(begin)](std::unique_ptr<PreparedScene> prepared,
                                                         std::uint64_t number) {
                            begin(*this, number);
                            if (number == 2) second_anew_ = prepared->starts_anew;
                            return true;
                        }}) {
        options_.output = OutputFormat::mono;
        scene_.simulation.ir_length_s = 0.1F;
    }

    ChangePreparer& changes() { return changes_; }
    std::uint64_t request(bool anew) { return changes_.request(scene_, options_, anew); }

    /// Whether the second change begins anew, once nothing is being prepared.
    std::optional<bool> second_anew() {
        if (!test::eventually([&] { return !changes_.status().preparing; })) return {};
        return second_anew_;
    }

 private:
    Scene scene_ = test::free_field({1, 0, 0});
    PlaybackOptions options_;
    std::optional<bool> second_anew_;
    ChangePreparer changes_;  ///< ends before the members that its thread uses
};

}  // namespace

TEST_CASE("A change continues a new scene that has begun, and begins one that failed to") {
    // The second change is requested while the first one begins, and so does not replace it.
    Preparation begun([](Preparation& now, std::uint64_t number) {
        now.changes().set_begun();
        if (number == 1) now.request(false);
    });
    begun.request(true);
    CHECK(begun.second_anew() == false);
    CHECK(begun.changes().status().failed == 0);

    Preparation failed([](Preparation& now, std::uint64_t number) {
        if (number > 1) return now.changes().set_begun();
        now.request(false);
        throw Failure("no memory");
    });
    failed.request(true);
    CHECK(failed.second_anew() == true);
    CHECK(failed.changes().status().failed == 1);
    CHECK(failed.changes().status().error.empty());
}

TEST_CASE("A change that has to be prepared for another rate is, unless a newer one is requested") {
    for (const bool has_newer : {false, true}) {
        Scene scene = test::free_field({1, 0, 0});
        scene.simulation.ir_length_s = 0.1F;
        PlaybackOptions options;
        options.output = OutputFormat::mono;
        std::vector<std::pair<std::uint64_t, double>> begun;  // number, rate
        std::unique_ptr<ChangePreparer> changes;
        std::mutex constructed;
        std::unique_lock lock(constructed);
        const auto begin = [&](std::unique_ptr<PreparedScene> prepared, std::uint64_t number) {
            const std::lock_guard wait(constructed);
            begun.emplace_back(number, prepared->options.sample_rate_hz);
            if (prepared->options.sample_rate_hz == 44100) return true;
            changes->set_sample_rate(44100);
            if (has_newer) changes->request(scene, options, false);
            return false;
        };
        changes = std::make_unique<ChangePreparer>(
            48000, ChangePreparer::Hooks{
                       .reusable = [] { return Reusable{}; },
                       .state = [](const PreparedScene& prepared) { return prepared.state({}, 0); },
                       .begin = begin});
        changes->request(scene, options, false);
        lock.unlock();
        REQUIRE(test::eventually([&] { return !changes->status().preparing; }));
        changes->stop();
        CHECK(begun == std::vector<std::pair<std::uint64_t, double>>{{1, 48000},
                                                                     {has_newer ? 2 : 1, 44100}});
        CHECK(changes->status().failed == 0);
    }
}

TEST_CASE("A change keeps the HRTF, and another one or another rate does not") {
    const Scene scene = test::free_field({1, 0, 0});
    PlaybackOptions options;
    const PreparedScene first(scene, options, false);
    const auto hrtf = first.built->computer.hrtf();
    REQUIRE(hrtf);
    Reusable before;
    before.auralizer = first.auralizer.get();
    const PreparedScene same(scene, options, false, before);
    CHECK_FALSE(same.auralizer);
    CHECK(same.built->computer.hrtf() == hrtf);
    options.sample_rate_hz = 44100;
    const PreparedScene other(scene, options, false, before);
    CHECK(other.auralizer);
    CHECK(other.built->computer.hrtf() != hrtf);
}

TEST_CASE("A scene player refuses headphones that cannot be read") {
    ScenePlayerOptions options;
    options.device = AudioDevice::kNone;
    options.headphones = "/nonexistent.wav";
    CHECK_THROWS_WITH(ScenePlayer(test::free_field({1, 0, 0}), options),
                      Catch::Contains("/nonexistent.wav"));
}
