#pragma once

#include <chrono>

namespace aula {

/// Measures lap times: lap_s() returns the seconds since its last call or the construction.
class Stopwatch {
 public:
    double lap_s() {
        const auto now = std::chrono::steady_clock::now();
        const double s = std::chrono::duration<double>(now - last_).count();
        last_ = now;
        return s;
    }

    /// The seconds since the construction.
    double total_s() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - first_).count();
    }

 private:
    std::chrono::steady_clock::time_point first_ = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last_ = first_;
};

}  // namespace aula
