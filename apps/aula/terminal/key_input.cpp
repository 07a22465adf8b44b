#include "apps/aula/terminal/key_input.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string_view>
#include <thread>

namespace aula {

namespace {

/// The bytes that a terminal sends for a key.
struct KeySequence {
    std::string_view bytes;
    Key key;
};

constexpr std::array<KeySequence, 17> kSequences{{
    {"w", Key::forward},
    {"W", Key::forward},
    {"\x1b[A", Key::forward},
    {"\x1bOA", Key::forward},
    {"s", Key::back},
    {"S", Key::back},
    {"\x1b[B", Key::back},
    {"\x1bOB", Key::back},
    {"a", Key::left},
    {"A", Key::left},
    {"d", Key::right},
    {"D", Key::right},
    {"\x1b[D", Key::turn_left},
    {"\x1bOD", Key::turn_left},
    {"\x1b[C", Key::turn_right},
    {"\x1bOC", Key::turn_right},
    {"?", Key::help},
}};

bool in_foreground() { return isatty(STDIN_FILENO) && tcgetpgrp(STDIN_FILENO) == getpgrp(); }

}  // namespace

KeyInput::KeyInput() {
    termios settings{};
    if (!in_foreground() || tcgetattr(STDIN_FILENO, &settings) != 0) return;
    saved_ = settings;
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    settings.c_cc[VMIN] = 0;
    settings.c_cc[VTIME] = 0;
    tcsetattr(STDIN_FILENO, TCSANOW, &settings);
}

KeyInput::~KeyInput() {
    if (saved_) tcsetattr(STDIN_FILENO, TCSANOW, &*saved_);
}

std::optional<Key> KeyInput::read(int timeout_ms) const {
    pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (!active() || !in_foreground()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(timeout_ms));
        return std::nullopt;
    }
    if (poll(&input, 1, timeout_ms) <= 0) return std::nullopt;
    // The sequence of one key arrives in one piece. Further keys remain for the next call.
    std::array<char, 3> bytes{};
    ssize_t count = ::read(STDIN_FILENO, bytes.data(), 1);
    if (count == 1 && bytes[0] == '\x1b' && poll(&input, 1, 0) > 0)
        count += std::max<ssize_t>(0, ::read(STDIN_FILENO, bytes.data() + 1, 2));
    if (count <= 0) return Key::quit;  // the terminal has been closed
    const std::string_view pressed(bytes.data(), static_cast<std::size_t>(count));
    if (pressed == "q" || pressed == "Q") return Key::quit;
    for (const auto& [sequence, key] : kSequences)
        if (pressed == sequence) return key;
    return std::nullopt;
}

}  // namespace aula
