#include "tests/plugin/editor/host_window.h"

#include <cstdlib>
#include <set>

namespace aula::test {

namespace {

bool is_near(std::uint32_t pixel, const std::array<int, 3>& colour) {
    constexpr int kTolerance = 8;  // of a rounded mean of drawn and background at an edge
    for (std::size_t c = 0; c < 3; ++c) {
        const int shade = static_cast<int>(pixel >> (16 - 8 * c) & 0xFF);
        if (std::abs(shade - colour[c]) > kTolerance) return false;
    }
    return true;
}

}  // namespace

std::optional<Pixel> HostWindow::mark(const std::array<int, 3>& colour) const {
    constexpr int kSize = 24;  // of a mark at most
    const std::vector<std::uint32_t> all = pixels();
    const int width = static_cast<int>(width_);
    std::optional<Pixel> first;
    std::array<long, 3> sum{};
    for (int y = 0; y < static_cast<int>(height_); ++y) {
        for (int x = 0; x < width; ++x) {
            if (!is_near(all[static_cast<std::size_t>(y * width + x)], colour)) continue;
            if (!first) first = Pixel{x, y};
            if (y - first->y > kSize || std::abs(x - first->x) > kSize) continue;
            sum[0] += x;
            sum[1] += y;
            ++sum[2];
        }
    }
    if (!first) return std::nullopt;
    return Pixel{static_cast<int>(sum[0] / sum[2]), static_cast<int>(sum[1] / sum[2])};
}

std::size_t HostWindow::colours() const {
    std::set<std::uint32_t> found;
    for (const std::uint32_t pixel : pixels())
        if (found.size() < 1000) found.insert(pixel);
    return found.size();
}

}  // namespace aula::test
