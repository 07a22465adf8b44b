#include "apps/aula/terminal/terminal.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

namespace aula {

StatusLine::StatusLine(bool enabled) : visible_(enabled && isatty(STDERR_FILENO)) {}

StatusLine::~StatusLine() { clear(); }

void StatusLine::show(const std::string& text) {
    if (!visible_) return;
    const std::size_t width = terminal_columns().value_or(80) - 1;
    std::fprintf(stderr, "\r%.*s\x1b[K", static_cast<int>(width), text.c_str());
    shown_ = true;
}

void StatusLine::clear() {
    if (shown_) std::fputs("\r\x1b[K", stderr);
    shown_ = false;
}

TaskLine::TaskLine(std::string what, bool enabled, std::chrono::steady_clock::duration after)
    : what_(std::move(what)), line_(enabled) {
    if (line_.visible()) thread_ = std::thread([this, after] { run(after); });
}

TaskLine::~TaskLine() {
    if (!thread_.joinable()) return;
    {
        const std::lock_guard lock(mutex_);
        done_ = true;
    }
    ended_.notify_one();
    thread_.join();
}

void TaskLine::run(std::chrono::steady_clock::duration after) {
    const auto begin = std::chrono::steady_clock::now();
    auto next = begin + after;
    std::unique_lock lock(mutex_);
    while (!ended_.wait_until(lock, next, [&] { return done_; })) {
        const auto passed = std::chrono::duration_cast<std::chrono::seconds>(next - begin);
        line_.show(what_ + ", " + std::to_string(passed.count()) + " s");
        next += std::chrono::seconds(1);
    }
}

ProgressLog::ProgressLog(std::string what, Time start)
    : what_(std::move(what)), start_(start), next_(start + std::chrono::seconds(2)) {}

std::string ProgressLog::line(double done, Time now) {
    if (now < next_) return {};
    next_ = now + std::chrono::seconds(10);
    const double passed_s = std::chrono::duration<double>(now - start_).count();
    return "aula: " + what_ + ": " + std::to_string(std::lround(done * 100)) + " % after " +
           std::to_string(std::lround(passed_s)) + " s";
}

}  // namespace aula
