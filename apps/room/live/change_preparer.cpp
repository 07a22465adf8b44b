#include "apps/room/live/change_preparer.h"

#include <exception>
#include <utility>

#include "aula/audio/realtime.h"

namespace aula {

ChangePreparer::ChangePreparer(double sample_rate_hz, Hooks hooks)
    : hooks_(std::move(hooks)), rate_hz_(sample_rate_hz), thread_([this] {
          lower_priority(kPropagationNice);
          run();
      }) {}

ChangePreparer::~ChangePreparer() { stop(); }

void ChangePreparer::stop() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wakeup_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void ChangePreparer::set_sample_rate(double sample_rate_hz) {
    const std::lock_guard lock(mutex_);
    rate_hz_ = sample_rate_hz;
    if (requested_) requested_->options.sample_rate_hz = sample_rate_hz;
}

std::uint64_t ChangePreparer::request(Scene scene, PlaybackOptions options, bool starts_anew) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        const bool anew = starts_anew || (requested_ && requested_->starts_anew) || preparing_anew_;
        number = ++last_number_;
        options.sample_rate_hz = rate_hz_;
        requested_ = Change{std::move(scene), std::move(options), anew, number};
    }
    wakeup_.notify_all();
    return number;
}

std::uint64_t ChangePreparer::request_if_idle(Scene scene, PlaybackOptions options) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        if (!idle()) return 0;
        number = ++last_number_;
        options.sample_rate_hz = rate_hz_;
        requested_ = Change{std::move(scene), std::move(options), false, number};
    }
    wakeup_.notify_all();
    return number;
}

void ChangePreparer::set_begun() {
    const std::lock_guard lock(mutex_);
    preparing_anew_ = false;
    error_.clear();
}

ChangePreparer::Status ChangePreparer::status() const {
    const std::lock_guard lock(mutex_);
    return {!idle(), failed_, error_};
}

/// Prepares a change and begins it. False: it has to be made again.
bool ChangePreparer::make(const Change& change) {
    Reusable before = hooks_.reusable();
    const bool other_rate = change.options.sample_rate_hz != before.options.sample_rate_hz;
    // A scene that begins anew plays its own signals.
    if (change.starts_anew || other_rate) before.sources.clear();
    auto prepared =
        std::make_unique<PreparedScene>(change.scene, change.options, change.starts_anew, before);
    prepared->built->computer.warm_up(hooks_.state(*prepared));
    {
        const std::lock_guard lock(mutex_);
        if (stop_) return true;
    }
    return hooks_.begin(std::move(prepared), change.number);
}

/// [preparing thread]
void ChangePreparer::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wakeup_.wait(lock, [this] { return stop_ || requested_; });
        if (stop_) return;
        Change change = *std::exchange(requested_, {});
        preparing_ = true;
        preparing_anew_ = change.starts_anew;
        lock.unlock();
        std::string error;
        bool made = true;
        try {
            made = make(change);
        } catch (const std::exception& thrown) {
            error = thrown.what();
        }
        lock.lock();
        preparing_ = preparing_anew_ = false;
        if (!made && !requested_) {
            change.options.sample_rate_hz = rate_hz_;
            requested_ = std::move(change);
        }
        if (error.empty()) continue;
        error_ = error;
        ++failed_;
    }
}

}  // namespace aula
