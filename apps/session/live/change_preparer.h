#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "apps/session/frames/play_controls.h"
#include "apps/session/live/prepared_scene.h"

namespace aula {

/// Prepares the next playback on a separate thread during playback. Of several requests the newest
/// is prepared. The thread also destroys playbacks that are no longer used.
class ChangePreparer {
 public:
    /// The present playback.
    struct Playing {
        Reusable reusable;
        PlayControls controls;
        double scene_time_s = 0;
    };

    struct Status {
        bool preparing = false;    ///< a requested change has neither begun nor failed
        std::uint64_t failed = 0;  ///< changes that could not be prepared
        std::string error;         ///< why the last one failed; empty if it did not
    };

    /// Begins to play a prepared change.
    using Begin = std::function<void(std::unique_ptr<PreparedScene>, std::uint64_t number)>;

    /// The thread calls the functions without holding a lock.
    ChangePreparer(double sample_rate_hz, std::function<Playing()> playing, Begin begin);
    ~ChangePreparer();
    ChangePreparer(const ChangePreparer&) = delete;
    ChangePreparer& operator=(const ChangePreparer&) = delete;

    /// Requests a scene. It replaces an earlier request that is not being prepared yet; if that one
    /// was to begin anew, this one does. Returns its number (>= 1). [any thread]
    std::uint64_t ask(const Scene& scene, const SessionOptions& options, bool starts_anew);

    /// The same for a scene that continues. Returns 0 and does nothing if a change is being
    /// prepared. [any thread]
    std::uint64_t ask_if_idle(const Scene& scene, const SessionOptions& options);

    /// Destroys a playback on the thread. [any thread]
    void retire(std::unique_ptr<ScenePlayback> playback);

    /// Ends the thread; no change begins afterwards. [the owner's thread]
    void stop();

    Status status() const;

 private:
    struct Change {
        Scene scene;
        SessionOptions options;
        bool starts_anew = false;
        std::uint64_t number = 0;
    };

    bool idle() const { return !asked_ && !in_work_; }
    void run();
    void make(const Change& change);

    double rate_hz_;
    std::function<Playing()> playing_;
    Begin begin_;
    mutable std::mutex mutex_;  ///< protects the following members
    std::condition_variable wanted_;
    bool stop_ = false;
    std::optional<Change> asked_;
    bool in_work_ = false;
    bool anew_in_work_ = false;  ///< the change that is being prepared begins anew
    std::uint64_t last_number_ = 0;
    std::uint64_t failed_ = 0;
    std::string error_;
    std::vector<std::unique_ptr<ScenePlayback>> spent_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
