#include "engine/base/worker_pool.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "aula/exception.h"

namespace aula {

namespace {

/// A thread waits for this time before it sleeps: about as long as the system takes to wake it.
constexpr std::chrono::microseconds kWakeful{100};

/// Leaves the core to its other hardware thread for a moment.
void pause_thread() {
#if defined(__x86_64__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");
#endif
}

}  // namespace

int default_threads() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
}

struct WorkerPool::State {
    std::mutex mutex;
    std::condition_variable start;
    std::condition_variable done;
    const std::function<void(std::size_t)>* job = nullptr;  // null between rounds
    std::size_t count = 0;
    std::atomic<std::size_t> next{0};
    std::atomic<std::size_t> round{0};  // number of calls; a worker joins each at most once
    std::atomic<int> working{0};        // workers inside the present round
    std::exception_ptr failed;          // the first exception of the present round
    std::atomic<bool> stop{false};
    bool wakeful = false;  // each thread has a processor
    std::vector<std::thread> threads;

    ~State() {
        {
            const std::lock_guard lock(mutex);
            stop = true;
        }
        start.notify_all();
        for (std::thread& thread : threads) thread.join();
    }

    void work_through(const std::function<void(std::size_t)>& present) {
        try {
            for (std::size_t i = next++; i < count; i = next++) present(i);
        } catch (...) {
            next = count;  // the other threads finish their present jobs only
            const std::lock_guard lock(mutex);
            if (!failed) failed = std::current_exception();
        }
    }

    /// Waits until a condition holds, at most for kWakeful. A thread that yielded instead would be
    /// late in the next round if other programs have work for its processor.
    template <typename Condition>
    void wait_awake(const Condition& condition) const {
        if (!wakeful) return;
        const auto end = std::chrono::steady_clock::now() + kWakeful;
        while (!condition() && std::chrono::steady_clock::now() < end) pause_thread();
    }

    void thread_main() {
        std::size_t seen = 0;
        const auto called = [&] { return stop || round != seen; };
        for (;;) {
            wait_awake(called);
            std::unique_lock lock(mutex);
            start.wait(lock, called);
            if (stop) return;
            seen = round;
            if (!job) continue;  // the others have done all jobs
            const auto& present = *job;
            ++working;
            lock.unlock();
            work_through(present);
            lock.lock();
            if (--working == 0) done.notify_one();
        }
    }
};

WorkerPool::WorkerPool(int threads) : state_(std::make_unique<State>()) {
    assert(threads >= 1);
    state_->wakeful = static_cast<unsigned>(threads) <= std::thread::hardware_concurrency();
    for (int t = 1; t < threads; ++t) {
        try {
            state_->threads.emplace_back([state = state_.get()] { state->thread_main(); });
        } catch (const std::system_error& error) {
            throw Failure("thread " + std::to_string(t + 1) + " of " + std::to_string(threads) +
                          " cannot be started: " + error.code().message() +
                          "; expected fewer threads");
        }
    }
}

WorkerPool::~WorkerPool() = default;

int WorkerPool::threads() const { return static_cast<int>(state_->threads.size()) + 1; }

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t)>& job) {
    State& s = *state_;
    if (s.threads.empty() || count <= 1) {
        for (std::size_t i = 0; i < count; ++i) job(i);
        return;
    }
    {
        const std::lock_guard lock(s.mutex);
        s.job = &job;
        s.count = count;
        s.next = 0;
        ++s.round;
    }
    s.start.notify_all();
    s.work_through(job);
    const auto done = [&] { return s.working == 0; };
    {
        const std::lock_guard lock(s.mutex);
        s.job = nullptr;
    }
    s.wait_awake(done);
    std::unique_lock lock(s.mutex);
    s.done.wait(lock, done);
    if (s.failed) std::rethrow_exception(std::exchange(s.failed, nullptr));
}

}  // namespace aula
