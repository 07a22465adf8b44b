#include "apps/session/live/change_preparer.h"

#include <exception>
#include <utility>

#include "aula/audio/realtime.h"

namespace aula {

namespace {

/// A change begins with what so much time brings into its caches, so that it does not begin noisy.
constexpr double kWarmUp_s = 0.25;

}  // namespace

ChangePreparer::ChangePreparer(double sample_rate_hz, std::function<Playing()> playing)
    : rate_hz_(sample_rate_hz), playing_(std::move(playing)), thread_([this] {
          lower_priority(kPropagationNice);
          run();
      }) {}

ChangePreparer::~ChangePreparer() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wanted_.notify_all();
    thread_.join();
    spent_playbacks_.clear();
}

std::uint64_t ChangePreparer::ask(const Scene& scene, const SessionOptions& options,
                                  bool starts_anew) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        const bool anew = starts_anew || (asked_ && asked_->starts_anew) || in_work_ == true ||
                          (prepared_.scene && prepared_.scene->starts_anew);
        number = ++last_number_;
        asked_ = Change{scene, options, anew, number};
    }
    wanted_.notify_all();
    return number;
}

std::uint64_t ChangePreparer::ask_if_idle(const Scene& scene, const SessionOptions& options) {
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        if (!idle()) return 0;
        number = ++last_number_;
        asked_ = Change{scene, options, false, number};
    }
    wanted_.notify_all();
    return number;
}

ChangePreparer::Prepared ChangePreparer::take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(prepared_, {});
}

void ChangePreparer::retire(std::unique_ptr<PreparedScene> prepared) {
    {
        const std::lock_guard lock(mutex_);
        spent_.push_back(std::move(prepared));
    }
    wanted_.notify_all();
}

void ChangePreparer::retire(std::unique_ptr<ScenePlayback> playback) {
    {
        const std::lock_guard lock(mutex_);
        spent_playbacks_.push_back(std::move(playback));
    }
    wanted_.notify_all();
}

ChangePreparer::Status ChangePreparer::status() const {
    const std::lock_guard lock(mutex_);
    return {!idle(), failed_, error_};
}

std::unique_ptr<PreparedScene> ChangePreparer::prepare(const Change& change) const {
    Playing playing = playing_();
    // What begins anew plays what its scene says.
    if (change.starts_anew)
        playing = {{{}, {}, playing.reusable.options, playing.reusable.hrtf}, {}, 0};
    auto prepared = std::make_unique<PreparedScene>(change.scene, change.options, rate_hz_,
                                                    change.starts_anew, playing.reusable);
    prepared->maker.warm_up(playing.controls.applied_to(prepared->scene, playing.scene_time_s),
                            kWarmUp_s);
    return prepared;
}

/// [preparing thread]
void ChangePreparer::run() {
    std::unique_lock lock(mutex_);
    for (;;) {
        wanted_.wait(lock, [this] {
            return stop_ || asked_ || !spent_.empty() || !spent_playbacks_.empty();
        });
        if (stop_) return;
        auto unused_playbacks = std::exchange(spent_playbacks_, {});
        auto unused = std::exchange(spent_, {});
        const std::optional<Change> change = std::exchange(asked_, {});
        if (change) in_work_ = change->starts_anew;
        lock.unlock();
        unused_playbacks.clear();
        unused.clear();
        std::unique_ptr<PreparedScene> prepared;
        std::string error;
        try {
            if (change) prepared = prepare(*change);
        } catch (const std::exception& thrown) {
            error = thrown.what();
        }
        lock.lock();
        if (!change) continue;
        in_work_.reset();
        error_ = error;
        if (!error.empty()) ++failed_;
        if (!prepared) continue;
        // One that was prepared before and has not begun gives way.
        std::swap(prepared_.scene, prepared);
        prepared_.number = change->number;
        if (prepared) spent_.push_back(std::move(prepared));
    }
}

}  // namespace aula
