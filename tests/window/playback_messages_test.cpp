#include "apps/window/model/playback_messages.h"

#include <catch2/catch.hpp>

using namespace aula;

namespace {

/// The messages of a sequence of statuses.
struct Played {
    PlaybackMessages messages;
    MessageLog log;
    double now_s = 0;

    bool take(const PlayStatus& status, const MonitorStatus& monitor = {}) {
        return messages.take(status, monitor, ++now_s, log);
    }
    std::size_t count(const std::string& text) const {
        std::size_t found = 0;
        for (const auto& message : log.messages()) found += message.text == text ? 1 : 0;
        return found;
    }
};

}  // namespace

TEST_CASE("Muted samples give one message") {
    Played played;
    PlayStatus status;
    CHECK_FALSE(played.take(status));
    CHECK(played.log.messages().empty());
    status.muted_samples = 10;
    played.take(status);
    status.muted_samples = 20;
    played.take(status);
    CHECK(played.count("samples that are not finite, or beyond 1e6, are muted") == 1);
    CHECK(played.log.messages().back().is_error);
}

TEST_CASE("Sources that do not reach the listener give one message until it changes") {
    Played played;
    PlayStatus status;
    status.sources.resize(3);
    const std::string why =
        " the listener, for instance from outside of the room, out of an object or through walls "
        "that transmit nothing";
    const std::string all = "no sound reaches" + why;
    played.take(status);
    CHECK(played.log.messages().empty());
    status.silent_pairs = 3;
    played.take(status);
    played.take(status);
    CHECK(played.count(all) == 1);
    CHECK(played.log.messages().back().is_error);
    status.silent_pairs = 1;
    played.take(status);
    played.take(status);
    CHECK(played.count(all) == 0);
    CHECK(played.count("nothing of 1 of 3 sources reaches" + why) == 1);
    // One more source: the text follows.
    status.sources.resize(4);
    played.take(status);
    CHECK(played.count("nothing of 1 of 4 sources reaches" + why) == 1);
    status.silent_pairs = 0;
    played.take(status);
    played.take(status);
    REQUIRE(played.log.messages().size() == 1);
    CHECK(played.log.messages()[0].text == "sound of each source reaches the listener");
    CHECK_FALSE(played.log.messages()[0].is_error);
}

TEST_CASE("Each failed change gives a message and is reported once") {
    Played played;
    PlayStatus status;
    for (std::uint64_t failure = 1; failure <= 2; ++failure) {
        status.failed_changes = failure;
        status.change_error = "no rays";
        CHECK(played.take(status));
        CHECK_FALSE(played.take(status));
        CHECK(played.count("no rays") == failure);
    }
}

TEST_CASE("The time of the last underrun is kept") {
    Played played;
    PlayStatus status;
    status.time_s = 3;
    played.take(status);
    CHECK(played.messages.last_underrun_s() < 0);
    status.underruns = 1;
    played.take(status);
    status.time_s = 8;
    played.take(status);
    CHECK(played.messages.last_underrun_s() == 3);
    status.underruns = 2;
    played.take(status);
    CHECK(played.messages.last_underrun_s() == 8);
}

TEST_CASE("A recording that ends early gives one message, also the second time") {
    Played played;
    MonitorStatus monitor;
    monitor.error = "disk full";
    played.take({}, monitor);
    played.take({}, monitor);
    CHECK(played.count("disk full") == 1);
    played.take({}, {});
    played.take({}, monitor);
    CHECK(played.count("disk full") == 2);
}

TEST_CASE("A reduced number of rays gives a message when it has been constant for some seconds") {
    Played played;
    PlayStatus status;
    status.rays = 300;
    status.full_rays = 1000;
    for (int second = 0; second < 10; ++second) played.take(status);
    REQUIRE(played.log.messages().size() == 1);
    CHECK(played.log.messages()[0].text.starts_with("this machine keeps up with 300 of 1000 rays"));
    CHECK_FALSE(played.log.messages()[0].is_error);
}
