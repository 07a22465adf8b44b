#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace aula {

/// Columns of the terminal on standard error; nothing if they are not known.
std::optional<std::size_t> terminal_columns();

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
