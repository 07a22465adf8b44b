#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "audio/base/realtime.h"

namespace aula {

/// Hands values of one writer thread to one reader thread, lock-free: the newest wins, and
/// ownership of what was replaced or spent comes back to the writer, who fills it again. Neither
/// side waits; the reader neither allocates nor frees.
template <typename T>
class Mailbox {
 public:
    /// `most_held`: values that the reader holds at most, taken and not given back.
    explicit Mailbox(std::size_t most_held) : capacity_(most_held + 2), spent_(capacity_) {}
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    /// Frees what lies in the mailbox; what the reader took and did not give back is the reader's.
    ~Mailbox() {
        delete newest_.load(std::memory_order_acquire);
        while (reclaim()) {
        }
    }

    /// Values that circulate at most: those that the reader holds, the newest, and one that was
    /// replaced or given back.
    std::size_t capacity() const { return capacity_; }

    /// Publishes a value; one that was published before and not yet taken goes to the spent ones.
    /// Spent values that nobody reclaims are freed. [writer thread]
    void publish(std::unique_ptr<T> value) {
        assert(value);
        if (circulating_ == capacity_) reclaim();
        assert(circulating_ < capacity_);
        ++circulating_;
        // Release hands over the contents of the new value, acquire those of the replaced one.
        T* const replaced = newest_.exchange(value.release(), std::memory_order_acq_rel);
        if (replaced == nullptr) return;
        if (replaced_) --circulating_;
        replaced_.reset(replaced);
    }

    /// A spent value to be filled again, or null. [writer thread]
    std::unique_ptr<T> reclaim() {
        std::unique_ptr<T> value = std::move(replaced_);
        if (!value) {
            const std::size_t read = spent_read_.load(std::memory_order_relaxed);
            if (read == spent_written_.load(std::memory_order_acquire)) return nullptr;
            value.reset(spent_[read % capacity_]);
            spent_read_.store(read + 1, std::memory_order_release);
        }
        --circulating_;
        return value;
    }

    /// The newest value, or null if there is none since the last call. [reader thread, wait-free]
    T* take() noexcept AULA_NONBLOCKING {
        // Reading first keeps the cache line shared while nothing new is there.
        if (newest_.load(std::memory_order_relaxed) == nullptr) return nullptr;
        return newest_.exchange(nullptr, std::memory_order_acquire);
    }

    /// Gives a value that take() returned back to the writer. [reader thread, wait-free]
    void give_back(T* value) noexcept AULA_NONBLOCKING {
        const std::size_t written = spent_written_.load(std::memory_order_relaxed);
        // There is room: no more values circulate than the ring holds.
        assert(written - spent_read_.load(std::memory_order_acquire) < capacity_);
        spent_[written % capacity_] = value;
        spent_written_.store(written + 1, std::memory_order_release);
    }

 private:
    static constexpr std::size_t kCacheLine_bytes = 64;

    const std::size_t capacity_;
    std::vector<T*> spent_;  ///< ring, written by the reader
    // Each line is written by one side only, but for newest_, which changes hands.
    alignas(kCacheLine_bytes) std::atomic<T*> newest_{nullptr};
    alignas(kCacheLine_bytes) std::atomic<std::size_t> spent_written_{0};
    alignas(kCacheLine_bytes) std::atomic<std::size_t> spent_read_{0};
    std::unique_ptr<T> replaced_;
    std::size_t circulating_ = 0;  ///< published and not reclaimed, of the writer
};

}  // namespace aula
