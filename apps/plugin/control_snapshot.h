#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "apps/plugin/controls.h"
#include "aula/audio/realtime.h"

namespace aula::plugin {

/// The newest values of all controls, from one writer to any readers (a sequence lock: Boehm, "Can
/// seqlocks get along with programming language memory models?", 2012). The writer is wait-free.
class ControlSnapshot {
 public:
    ControlSnapshot() {
        for (std::size_t i = 0; i < kControls; ++i) values_[i] = control_infos()[i].initial;
    }

    /// [audio thread]
    void write(const ControlValues& values) noexcept AULA_NONBLOCKING {
        const std::uint32_t begin = version_.load(std::memory_order_relaxed);
        version_.store(begin + 1, std::memory_order_relaxed);
        std::atomic_thread_fence(std::memory_order_release);
        for (std::size_t i = 0; i < kControls; ++i)
            values_[i].store(values[i], std::memory_order_relaxed);
        version_.store(begin + 2, std::memory_order_release);
    }

    /// Values of one write().
    ControlValues read() const noexcept {
        ControlValues values;
        std::uint32_t begin;
        std::uint32_t end;
        do {
            begin = version_.load(std::memory_order_acquire);
            for (std::size_t i = 0; i < kControls; ++i)
                values[i] = values_[i].load(std::memory_order_relaxed);
            std::atomic_thread_fence(std::memory_order_acquire);
            end = version_.load(std::memory_order_relaxed);
        } while (begin != end || begin % 2 == 1);
        return values;
    }

 private:
    std::atomic<std::uint32_t> version_ = 0;
    std::array<std::atomic<float>, kControls> values_;
};

}  // namespace aula::plugin
