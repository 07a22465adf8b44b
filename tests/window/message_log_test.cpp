#include "apps/window/model/message_log.h"

#include <catch2/catch.hpp>

using aula::MessageLog;

TEST_CASE("The newest messages are kept, with the time at which they were added") {
    MessageLog log;
    for (int i = 0; i < 7; ++i) {
        log.set_time(i);
        log.say(std::to_string(i), i == 6);
    }
    REQUIRE(log.messages().size() == MessageLog::kMaxMessages);
    CHECK(log.messages().front().text == "2");
    CHECK(log.messages().front().time_s == 2);
    CHECK_FALSE(log.messages().front().is_error);
    CHECK(log.messages().back().text == "6");
    CHECK(log.messages().back().is_error);
}

TEST_CASE("Only the errors about a file are removed") {
    MessageLog log;
    log.say("church.json: missing comma", true);
    log.say("church.json reloaded");
    log.say("hall.json: missing comma", true);
    log.remove_errors("church.json");
    REQUIRE(log.messages().size() == 2);
    CHECK(log.messages()[0].text == "church.json reloaded");
    CHECK(log.messages()[1].text == "hall.json: missing comma");
}
