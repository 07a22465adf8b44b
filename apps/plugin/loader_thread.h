#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "audio/base/assume_nonblocking.h"
#include "aula/audio/realtime.h"
#include "process/semaphore.h"

namespace aula::plugin {

class LoaderTask;

/// The thread that builds and destroys the rooms of all instances in a process. It starts with the
/// first LoaderTask and ends with the last one.
class LoaderThread {
 public:
    LoaderThread();
    ~LoaderThread();
    LoaderThread(const LoaderThread&) = delete;
    LoaderThread& operator=(const LoaderThread&) = delete;

    /// That of the process.
    static std::shared_ptr<LoaderThread> get();

 private:
    friend class LoaderTask;

    void run();

    Semaphore wake_{0};
    std::mutex mutex_;  ///< of what follows
    std::condition_variable idle_;
    std::list<LoaderTask*> tasks_;  ///< the one that was served last is at the end
    LoaderTask* running_ = nullptr;
    bool stop_ = false;

    std::thread thread_;
};

/// The work of the loader thread for an instance.
class LoaderTask {
 public:
    /// `serve` is called on the loader thread after each wake(), once for several of them.
    explicit LoaderTask(std::function<void()> serve);
    ~LoaderTask() { stop(); }
    LoaderTask(const LoaderTask&) = delete;
    LoaderTask& operator=(const LoaderTask&) = delete;

    /// [any thread, wait-free]
    void wake() noexcept AULA_NONBLOCKING {
        due_ = true;
        // It increments a number, and wakes the thread by a system call if it waits.
        assume_nonblocking([this] { thread_->wake_.release(); });
    }

    /// Waits for a call in progress; no other one follows. [not the loader thread]
    void stop();

 private:
    friend class LoaderThread;

    const std::function<void()> serve_;
    std::atomic<bool> due_ = false;
    const std::shared_ptr<LoaderThread> thread_;
};

}  // namespace aula::plugin
