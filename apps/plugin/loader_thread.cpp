#include "apps/plugin/loader_thread.h"

#include <algorithm>
#include <utility>

namespace aula::plugin {

LoaderThread::LoaderThread() : thread_([this] { run(); }) {}

LoaderThread::~LoaderThread() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.release();
    thread_.join();
}

std::shared_ptr<LoaderThread> LoaderThread::get() {
    static std::mutex mutex;
    static std::weak_ptr<LoaderThread> present;
    const std::lock_guard lock(mutex);
    auto thread = present.lock();
    if (!thread) {
        thread = std::make_shared<LoaderThread>();
        present = thread;
    }
    return thread;
}

void LoaderThread::run() {
    leave_realtime();
    for (;;) {
        wake_.acquire();
        std::unique_lock lock(mutex_);
        if (stop_) return;
        const auto due = std::find_if(tasks_.begin(), tasks_.end(),
                                      [](LoaderTask* task) { return task->due_.exchange(false); });
        if (due == tasks_.end()) continue;
        running_ = *due;
        tasks_.splice(tasks_.end(), tasks_, due);
        lock.unlock();
        running_->serve_();
        lock.lock();
        running_ = nullptr;
        idle_.notify_all();
    }
}

LoaderTask::LoaderTask(std::function<void()> serve)
    : serve_(std::move(serve)), thread_(LoaderThread::get()) {
    const std::lock_guard lock(thread_->mutex_);
    thread_->tasks_.push_back(this);
}

void LoaderTask::stop() {
    std::unique_lock lock(thread_->mutex_);
    thread_->tasks_.remove(this);
    thread_->idle_.wait(lock, [this] { return thread_->running_ != this; });
}

}  // namespace aula::plugin
