#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <numeric>
#include <vector>

#include "aula/auralizer.h"

namespace aula {

/// Assigns the renderer's slots to sources. Equal sequences of calls give equal slots: the frames
/// and the renderer follow the same changes at different times.
class SourceSlots {
 public:
    explicit SourceSlots(std::size_t slots) : playing_(slots), free_(slots) {
        std::iota(free_.begin(), free_.end(), std::size_t{0});
    }

    /// The slot of a source that begins: the one that has been free the longest. There must be one.
    std::size_t begin(SourceId source) {
        const std::size_t slot = free_.front();
        free_.pop_front();
        playing_[slot] = source;
        return slot;
    }

    /// Frees the slot of a source that plays, and returns it.
    std::size_t end(SourceId source) {
        const auto at = std::find(playing_.begin(), playing_.end(), source);
        *at = {};
        free_.push_back(static_cast<std::size_t>(at - playing_.begin()));
        return free_.back();
    }

    /// [slot] The source that plays; number 0: none.
    const std::vector<SourceId>& playing() const { return playing_; }

 private:
    std::vector<SourceId> playing_;
    std::deque<std::size_t> free_;
};

}  // namespace aula
