#include "apps/unity/source_slot.h"

namespace aula::unity {

void SharedMatrix::store(const float (&matrix)[16]) noexcept {
    const std::uint32_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < 16; ++i) values_[i].store(matrix[i], std::memory_order_relaxed);
    version_.store(version + 2, std::memory_order_release);
}

bool SharedMatrix::load(float (&matrix)[16]) const noexcept {
    for (;;) {
        const std::uint32_t version = version_.load(std::memory_order_acquire);
        if (version == 0) return false;
        for (std::size_t i = 0; i < 16; ++i) matrix[i] = values_[i].load(std::memory_order_relaxed);
        std::atomic_thread_fence(std::memory_order_acquire);
        if (version % 2 == 0 && version_.load(std::memory_order_relaxed) == version) return true;
    }
}

void SourceSlot::put(const float* in, int samples, int channels, float share) noexcept {
    taken_ = samples;
    const float weight = share / static_cast<float>(channels);
    for (int n = 0; n < samples; ++n) {
        float sum = 0;
        for (int c = 0; c < channels; ++c) sum += in[n * channels + c];
        samples_[static_cast<std::size_t>(n)] = weight * sum;
    }
}

aula_signal SourceSlot::take(int samples) noexcept {
    const bool is_there = taken_ == samples;
    taken_ = 0;
    return {number.load(std::memory_order_relaxed), is_there ? samples_.data() : nullptr};
}

}  // namespace aula::unity
