#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "aula/audio/realtime.h"

namespace aula {

/// Passes values from one writer thread to one reader thread, lock-free. The reader gets the newest
/// value; replaced and used values return to the writer for reuse. Neither thread waits; the
/// reader neither allocates nor frees.
template <typename T>
class Mailbox {
 public:
    /// `max_held`: largest number of values that the reader has taken and not given back.
    explicit Mailbox(std::size_t max_held) : capacity_(max_held + 2), used_(capacity_) {}
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    /// Frees the values in the mailbox. Values not given back remain property of the reader.
    ~Mailbox() {
        delete newest_.load(std::memory_order_acquire);
        while (reclaim()) {
        }
    }

    /// Largest number of values in circulation: those that the reader holds, the newest, and one
    /// replaced or given back.
    std::size_t capacity() const { return capacity_; }

    /// Publishes a value and replaces the one not yet taken, if any. Used values that are not
    /// reclaimed are freed. [writer thread]
    void publish(std::unique_ptr<T> value) {
        assert(value);
        if (circulating_ == capacity_) reclaim();
        assert(circulating_ < capacity_);
        ++circulating_;
        // Release for the contents of the new value, acquire for those of the replaced one.
        T* const replaced = newest_.exchange(value.release(), std::memory_order_acq_rel);
        if (replaced == nullptr) return;
        if (replaced_) --circulating_;
        replaced_.reset(replaced);
    }

    /// A used value for reuse, or null. [writer thread]
    std::unique_ptr<T> reclaim() {
        std::unique_ptr<T> value = std::move(replaced_);
        if (!value) {
            const std::size_t read = used_read_.load(std::memory_order_relaxed);
            if (read == used_written_.load(std::memory_order_acquire)) return nullptr;
            value.reset(used_[read % capacity_]);
            used_read_.store(read + 1, std::memory_order_release);
        }
        --circulating_;
        return value;
    }

    /// The newest value, or null if none was published since the last call. The reader owns it
    /// until give_back(). [reader thread, wait-free]
    T* take() noexcept AULA_NONBLOCKING {
        // The load keeps the cache line shared while there is no new value.
        if (newest_.load(std::memory_order_relaxed) == nullptr) return nullptr;
        return newest_.exchange(nullptr, std::memory_order_acquire);
    }

    /// Returns a value from take() to the writer. [reader thread, wait-free]
    void give_back(T* value) noexcept AULA_NONBLOCKING {
        const std::size_t written = used_written_.load(std::memory_order_relaxed);
        // The ring has room for all values in circulation.
        assert(written - used_read_.load(std::memory_order_acquire) < capacity_);
        used_[written % capacity_] = value;
        used_written_.store(written + 1, std::memory_order_release);
    }

 private:
    static constexpr std::size_t kCacheLine_bytes = 64;

    const std::size_t capacity_;
    std::vector<T*> used_;  ///< ring, written by the reader
    // Each cache line is written by one thread only, except that of newest_.
    alignas(kCacheLine_bytes) std::atomic<T*> newest_{nullptr};
    alignas(kCacheLine_bytes) std::atomic<std::size_t> used_written_{0};
    alignas(kCacheLine_bytes) std::atomic<std::size_t> used_read_{0};
    std::unique_ptr<T> replaced_;
    std::size_t circulating_ = 0;  ///< values published and not reclaimed [writer thread]
};

}  // namespace aula
