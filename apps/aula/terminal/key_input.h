#pragma once

#include <termios.h>

#include <optional>

namespace aula {

enum class Key { forward, back, left, right, turn_left, turn_right, help, quit };

/// Reads single keys from standard input without echo. The destructor restores the terminal's
/// settings. Inactive if standard input is not a terminal or the process is in the background.
class KeyInput {
 public:
    KeyInput();
    ~KeyInput();
    KeyInput(const KeyInput&) = delete;
    KeyInput& operator=(const KeyInput&) = delete;

    bool active() const { return saved_.has_value(); }

    /// Waits for a key, at most `timeout_ms`. Empty at a timeout or an unknown key; Key::quit at
    /// the end of input.
    std::optional<Key> read(int timeout_ms) const;

 private:
    std::optional<termios> saved_;
};

}  // namespace aula
