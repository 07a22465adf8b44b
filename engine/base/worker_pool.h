#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace aula {

/// Threads that work through numbered jobs; the calling thread works too. [propagation thread]
class WorkerPool {
 public:
    /// `threads` >= 1, the caller included. Throws std::system_error if the system allows fewer.
    explicit WorkerPool(int threads);
    ~WorkerPool();

    int threads() const;

    /// Calls job(0) ... job(count - 1), each once, in any order and on any thread; returns when
    /// all are done. The first exception of a job is thrown when all threads have stopped; jobs
    /// that have not begun by then are left out.
    void run(std::size_t count, const std::function<void(std::size_t)>& job);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
