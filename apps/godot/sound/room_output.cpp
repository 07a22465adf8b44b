#include "apps/godot/sound/room_output.h"

#include <algorithm>
#include <chrono>

namespace aula::godot {

RoomOutput::RoomOutput(double sample_rate_hz)
    : signals_(kMostInputs), sample_rate_hz_(sample_rate_hz) {
    inputs_.reserve(kMostInputs);
}

aula_room* RoomOutput::exchange(aula_room* room, bool exact) noexcept {
    exact_ = exact;
    return std::exchange(room_, room);
}

bool RoomOutput::add(SourceInput& input) {
    if (inputs_.size() == kMostInputs) return false;
    inputs_.push_back(&input);
    return true;
}

void RoomOutput::remove(SourceInput& input) { std::erase(inputs_, &input); }

void RoomOutput::process(const StereoSample* /*from*/, StereoSample* to, int count) noexcept {
    const auto begin = std::chrono::steady_clock::now();
    if (!render(to, count)) std::fill_n(to, count, StereoSample{0, 0});
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    const double block_s = count / sample_rate_hz_;
    const auto weight = static_cast<float>(std::min(1.0, block_s));  // 1 s of blocks: 1
    const float old = load_.load(std::memory_order_relaxed);
    load_.store(old + weight * (static_cast<float>(taken.count() / block_s) - old),
                std::memory_order_relaxed);
}

bool RoomOutput::render(StereoSample* to, int count) noexcept {
    std::size_t signals = 0;
    for (SourceInput* input : inputs_) {
        const aula_signal signal = input->take(count);
        if (signal.source != 0) signals_[signals++] = signal;
    }
    if (room_ == nullptr || count > SourceInput::kMostSamples) return false;
    const std::array<float*, 2> outputs{left_.data(), right_.data()};
    const auto process = exact_ ? aula_room_process_exactly : aula_room_process;
    if (process(room_, signals_.data(), signals, outputs.data(), outputs.size(), count) != AULA_OK)
        return false;
    for (int n = 0; n < count; ++n)
        to[n] = {left_[static_cast<std::size_t>(n)], right_[static_cast<std::size_t>(n)]};
    return true;
}

}  // namespace aula::godot
