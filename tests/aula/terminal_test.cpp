#include "apps/aula/terminal/terminal.h"
#include "apps/output/printable.h"

#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>

using aula::printable;
using aula::ProgressLog;
using aula::TaskLine;

namespace {

/// Replaces standard error by a pseudo-terminal while alive.
class TerminalOnStderr {
 public:
    TerminalOnStderr() : saved_(dup(STDERR_FILENO)) {
        int inside = -1;
        REQUIRE(openpty(&outside_, &inside, nullptr, nullptr, nullptr) == 0);
        dup2(inside, STDERR_FILENO);
        close(inside);
    }
    ~TerminalOnStderr() {
        dup2(saved_, STDERR_FILENO);
        close(saved_);
        close(outside_);
    }
    TerminalOnStderr(const TerminalOnStderr&) = delete;
    TerminalOnStderr& operator=(const TerminalOnStderr&) = delete;

    /// The next output of the terminal; empty after `timeout_ms`.
    std::string next(int timeout_ms) const {
        pollfd waiting{outside_, POLLIN, 0};
        if (poll(&waiting, 1, timeout_ms) <= 0) return {};
        std::array<char, 4096> text{};
        const ssize_t count = read(outside_, text.data(), text.size());
        return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
    }

 private:
    int saved_;
    int outside_ = -1;
};

}  // namespace

TEST_CASE("A long task is shown with its elapsed seconds and erased at its end") {
    const TerminalOnStderr terminal;
    std::string seen;
    constexpr int kLong_ms = 10'000;
    {
        const TaskLine line("reading hall.json", true, std::chrono::seconds(0));
        while (seen.find("reading hall.json, 1 s") == std::string::npos) {
            const std::string more = terminal.next(kLong_ms);
            REQUIRE_FALSE(more.empty());
            seen += more;
        }
    }
    CHECK(seen.find("\rreading hall.json, 0 s\x1b[K") != std::string::npos);
    CHECK(terminal.next(kLong_ms) == "\r\x1b[K");
}

TEST_CASE("Short tasks and disabled ones show nothing") {
    const TerminalOnStderr terminal;
    { const TaskLine line("reading hall.json", true, std::chrono::hours(1)); }
    { const TaskLine line("reading hall.json", false, std::chrono::seconds(0)); }
    CHECK(terminal.next(0).empty());
}

TEST_CASE("Printed names contain no control characters except line feeds") {
    CHECK(printable("hall \x1b[31mred\x07") == "hall \\x1b[31mred\\x07");
    CHECK(printable("a\rb\tc\x7f") == "a\\x0db\\x09c\\x7f");
    // The control sequence introducer as one byte and as U+009B.
    CHECK(printable("\x9b"
                    "31m") == "\\x9b31m");
    CHECK(printable("\xc2\x9b"
                    "31m") == "\\xc2\\x9b31m");
    // A surrogate, and a character that is longer than necessary.
    CHECK(printable("\xed\xa0\x80 \xe0\x80\x80") == "\\xed\\xa0\\x80 \\xe0\\x80\\x80");
    CHECK(aula::printable_line("a\nb\t") == "a\\x0ab\\x09");
    CHECK(printable("cut \xe2\x82") == "cut \\xe2\\x82");
    CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
    // A reversal of the writing direction, and an isolate.
    CHECK(printable("hall\u202Etxt.\u2066") == "hall\\xe2\\x80\\xaetxt.\\xe2\\x81\\xa6");
    // Other text, and the line feeds of tables, stay unchanged.
    const std::string text = "Größe 5 m² → 漢字 🎵\nnext";
    CHECK(printable(text) == text);
}

TEST_CASE("A log has a line of progress after 2 s, then one every ten seconds") {
    const ProgressLog::Time start{};
    const auto after = [&](double seconds) {
        return start + std::chrono::duration_cast<ProgressLog::Time::duration>(
                           std::chrono::duration<double>(seconds));
    };
    ProgressLog log("measuring", start);
    CHECK(log.line(0, start) == "");
    CHECK(log.line(0.05, after(1.9)) == "");
    CHECK(log.line(0.11, after(2.2)) == "aula: measuring: 11 % after 2 s");
    CHECK(log.line(0.5, after(12.1)) == "");
    CHECK(log.line(0.614, after(12.7)) == "aula: measuring: 61 % after 13 s");
}
