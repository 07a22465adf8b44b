#include "apps/godot/sound/source_input.h"

#include <algorithm>

namespace aula::godot {

void SourceInput::process(const StereoSample* from, StereoSample* to, int count) noexcept {
    taken_ = std::min(count, kMostSamples);
    for (int n = 0; n < taken_; ++n)
        samples_[static_cast<std::size_t>(n)] = (from[n].left + from[n].right) / 2;
    std::fill_n(to, count, StereoSample{0, 0});
}

aula_signal SourceInput::take(int count) noexcept {
    const bool is_there = taken_ == count;
    taken_ = 0;
    return {number, is_there ? samples_.data() : nullptr};
}

}  // namespace aula::godot
