#pragma once

#include <termios.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace aula {

/// Text without control characters but line ends, which names in files may hold to change the
/// terminal: those, and bytes that are not UTF-8, are shown as \x1b.
std::string printable(const std::string& text);

enum class Key { forward, back, left, right, turn_left, turn_right, help, quit };

/// Single keys from standard input while alive, without echo; the terminal is as before
/// afterwards. Does nothing where standard input is no terminal, or not ours to read.
class KeyInput {
 public:
    KeyInput();
    ~KeyInput();
    KeyInput(const KeyInput&) = delete;
    KeyInput& operator=(const KeyInput&) = delete;

    bool active() const { return saved_.has_value(); }

    /// The next key, waiting for it up to a time; empty if none of ours was pressed.
    std::optional<Key> read(int timeout_ms) const;

 private:
    std::optional<termios> saved_;
};

/// One line on standard error that is written over again and again; nothing where that is no
/// terminal.
class StatusLine {
 public:
    explicit StatusLine(bool wanted);
    ~StatusLine();
    StatusLine(const StatusLine&) = delete;
    StatusLine& operator=(const StatusLine&) = delete;

    bool visible() const { return visible_; }

    /// Shows a line, cut to the terminal's width.
    void show(const std::string& text);

    /// Wipes it out, to make room for other output.
    void clear();

 private:
    bool visible_;
    bool shown_ = false;
};

/// Shows what is being done and for how many seconds on a status line, once it takes long. Nothing
/// else may be printed meanwhile.
class TaskLine {
 public:
    TaskLine(std::string what, bool wanted,
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
