#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <span>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// A lock-free queue of samples from one writer thread to one reader thread. Neither thread waits.
class SampleRing {
 public:
    /// The capacity is rounded up to a power of two.
    explicit SampleRing(std::size_t capacity) : samples_(std::bit_ceil(capacity)) {}

    /// Writes all samples, or none and returns false if they do not fit. [writer thread, wait-free]
    bool write(std::span<const float> samples) noexcept AULA_NONBLOCKING {
        const std::size_t written = written_.load(std::memory_order_relaxed);
        if (written - read_.load(std::memory_order_acquire) + samples.size() > samples_.size())
            return false;
        const std::size_t mask = samples_.size() - 1;
        for (std::size_t i = 0; i < samples.size(); ++i)
            samples_[(written + i) & mask] = samples[i];
        written_.store(written + samples.size(), std::memory_order_release);
        return true;
    }

    /// Reads up to out.size() samples. Returns their number. [reader thread, wait-free]
    std::size_t read(std::span<float> out) noexcept AULA_NONBLOCKING {
        const std::size_t read = read_.load(std::memory_order_relaxed);
        const std::size_t count =
            std::min(written_.load(std::memory_order_acquire) - read, out.size());
        const std::size_t mask = samples_.size() - 1;
        for (std::size_t i = 0; i < count; ++i) out[i] = samples_[(read + i) & mask];
        read_.store(read + count, std::memory_order_release);
        return count;
    }

    /// Number of samples available. [reader thread, wait-free]
    std::size_t size() const noexcept AULA_NONBLOCKING {
        return written_.load(std::memory_order_acquire) - read_.load(std::memory_order_relaxed);
    }

    /// Discards up to `count` samples. [reader thread, wait-free]
    void skip(std::size_t count) noexcept AULA_NONBLOCKING {
        const std::size_t read = read_.load(std::memory_order_relaxed);
        read_.store(read + std::min(count, size()), std::memory_order_release);
    }

 private:
    std::vector<float> samples_;
    std::atomic<std::size_t> written_{0};
    std::atomic<std::size_t> read_{0};
};

}  // namespace aula
