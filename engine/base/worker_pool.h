#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

namespace aula {

/// The number of threads by default: all processors but one, at least 1.
int default_threads();

/// A thread pool for numbered jobs. The calling thread takes part. [propagation thread]
class WorkerPool {
 public:
    /// `threads` >= 1 includes the caller. Throws Failure if the system allows fewer.
    explicit WorkerPool(int threads);
    ~WorkerPool();

    int threads() const;

    /// Calls job(0) ... job(count - 1), each once, in any order and on any thread of the pool.
    /// Returns after the last job. If a job throws, no further jobs start, and the first exception
    /// is thrown when all threads have stopped.
    void run(std::size_t count, const std::function<void(std::size_t)>& job);

    /// Calls each job once in the same way.
    void run(std::span<const std::function<void()>> jobs) {
        run(jobs.size(), [&](std::size_t i) { jobs[i](); });
    }

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
