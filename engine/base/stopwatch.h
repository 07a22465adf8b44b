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

 private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace aula
