#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace aula {

/// Hands values from one thread to another in order; both wait. Not for the audio thread.
template <typename T>
class BlockingQueue {
 public:
    /// `capacity`: values that lie in the queue at most, at least 1.
    explicit BlockingQueue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits for room. Returns false, and drops the value, if the queue is closed.
    bool push(T value) {
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return closed_ || values_.size() < capacity_; });
            if (closed_) return false;
            values_.push_back(std::move(value));
        }
        changed_.notify_all();
        return true;
    }

    /// The oldest value, waiting for one; empty once the queue is closed and used up.
    std::optional<T> pop() {
        std::optional<T> value;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return closed_ || !values_.empty(); });
            if (values_.empty()) return std::nullopt;
            value = std::move(values_.front());
            values_.pop_front();
        }
        changed_.notify_all();
        return value;
    }

    /// Ends all waits; what lies in the queue can still be taken.
    void close() {
        {
            const std::lock_guard lock(mutex_);
            closed_ = true;
        }
        changed_.notify_all();
    }

 private:
    const std::size_t capacity_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> values_;
    bool closed_ = false;
};

}  // namespace aula
