#include "apps/aula/terminal/progress_bar.h"

#include <cmath>

#include "apps/aula/terminal/interrupt.h"

namespace aula {

ProgressBar::ProgressBar(const std::string& what, bool quiet) : what_(what), line_(!quiet) {
    (*this)(0);
}

bool ProgressBar::operator()(double done) {
    const auto now = std::chrono::steady_clock::now();
    if (line_.visible() && now >= next_) {
        next_ = now + std::chrono::milliseconds(100);
        constexpr std::size_t kWidth = 40;
        const auto full = static_cast<std::size_t>(std::lround(done * kWidth));
        line_.show(what_ + " [" + std::string(full, '#') + std::string(kWidth - full, '.') + "] " +
                   std::to_string(std::lround(done * 100)) + " %");
    }
    return interrupt_signal() == 0;
}

}  // namespace aula
