#include "apps/aula/terminal/progress_bar.h"

#include <cmath>
#include <cstdio>

#include "apps/aula/terminal/interrupt.h"

namespace aula {

ProgressBar::ProgressBar(const std::string& what, bool quiet, ProgressLines lines)
    : what_(what), line_(!quiet) {
    if (!quiet && !line_.visible() && lines == ProgressLines::logged)
        log_.emplace(what, std::chrono::steady_clock::now());
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
    if (log_) {
        const std::string line = log_->line(done, now);
        if (!line.empty()) std::fprintf(stderr, "%s\n", line.c_str());
    }
    return interrupt_signal() == 0;
}

}  // namespace aula
