#pragma once

#include <termios.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

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

/// A status line on standard error, overwritten in place. Invisible if standard error is not a
/// terminal.
class StatusLine {
 public:
    explicit StatusLine(bool enabled);
    ~StatusLine();
    StatusLine(const StatusLine&) = delete;
    StatusLine& operator=(const StatusLine&) = delete;

    bool visible() const { return visible_; }

    /// Replaces the line; truncates it to the terminal's width.
    void show(const std::string& text);

    /// Erases the line before other output.
    void clear();

 private:
    bool visible_;
    bool shown_ = false;
};

/// Lines of progress for a log: the first after 2 s, then one every ten seconds.
class ProgressLog {
 public:
    using Time = std::chrono::steady_clock::time_point;

    ProgressLog(std::string what, Time start);

    /// The line that is due for the completed share, 0..1; empty: none.
    std::string line(double done, Time now);

 private:
    std::string what_;
    Time start_;
    Time next_;
};

/// While alive, shows a task and its elapsed seconds on a status line, from `after` on. Nothing
/// else may be printed during its life.
class TaskLine {
 public:
    TaskLine(std::string what, bool enabled,
             std::chrono::steady_clock::duration after = std::chrono::seconds(2));
    ~TaskLine();
    TaskLine(const TaskLine&) = delete;
    TaskLine& operator=(const TaskLine&) = delete;

 private:
    void run(std::chrono::steady_clock::duration after);

    std::string what_;
    StatusLine line_;
    std::mutex mutex_;
    std::condition_variable ended_;
    bool done_ = false;
    std::thread thread_;
};

}  // namespace aula
