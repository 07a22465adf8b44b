#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace aula::test {

/// Polls a condition every 10 ms. False if it does not hold within 3 minutes: with the thread
/// sanitizer, beside a build, threads of low priority have taken more than 30 s.
inline bool eventually(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(3);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

}  // namespace aula::test
