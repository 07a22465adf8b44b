#include "aula/engine/time_bins.h"

#include <cassert>
#include <cmath>

namespace aula {
namespace {

int width_ms(int begin_ms) {
    if (begin_ms < 64) return 1;
    if (begin_ms < 128) return 2;
    if (begin_ms < 256) return 4;
    if (begin_ms < 1024) return 8;
    if (begin_ms < 2048) return 16;
    if (begin_ms < 4096) return 32;
    return 64;
}

}  // namespace

TimeBins::TimeBins(double length_s, int coarseness) {
    assert(std::isfinite(length_s) && length_s > 0 && coarseness >= 1);
    edges_s_.push_back(0);
    int begin_ms = 0;
    while (edges_s_.back() < length_s) {
        const int end_ms = begin_ms + width_ms(begin_ms) * coarseness;
        bin_of_ms_.resize(static_cast<std::size_t>(end_ms),
                          static_cast<std::uint32_t>(edges_s_.size() - 1));
        edges_s_.push_back(end_ms / 1000.0);
        begin_ms = end_ms;
    }
    // A time just before the end can round to the end in milliseconds.
    bin_of_ms_.push_back(static_cast<std::uint32_t>(count() - 1));
}

}  // namespace aula
