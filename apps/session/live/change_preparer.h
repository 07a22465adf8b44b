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

/// Prepares what is to be played next while something plays, the newest that is wanted at a time,
/// and takes down what is spent, on a thread of its own.
class ChangePreparer {
 public:
    /// What plays now.
    struct Playing {
        Reusable reusable;
        PlayControls controls;
        double scene_time_s = 0;
    };

    struct Prepared {
        std::unique_ptr<PreparedScene> scene;  ///< null if there is none
        std::uint64_t number = 0;
    };

    struct Status {
        bool preparing = false;    ///< something that was asked for is neither taken nor failed
        std::uint64_t failed = 0;  ///< how many could not be prepared
        std::string error;         ///< why the last could not; empty if it could
    };

    /// `playing` is called by the thread, which holds no lock then.
    ChangePreparer(double sample_rate_hz, std::function<Playing()> playing);
    ~ChangePreparer();
    ChangePreparer(const ChangePreparer&) = delete;
    ChangePreparer& operator=(const ChangePreparer&) = delete;

    /// Asks for a scene in place of what was asked for before and is not taken yet; its number,
    /// from 1 on. If that was to begin anew, so is this. [any thread]
    std::uint64_t ask(const Scene& scene, const SessionOptions& options, bool starts_anew);

    /// The same for what goes on, unless something is on its way: 0 then. [any thread]
    std::uint64_t ask_if_idle(const Scene& scene, const SessionOptions& options);

    /// What has been prepared since the last call. [propagation thread]
    Prepared take();

    /// To be taken down. [any thread]
    void retire(std::unique_ptr<PreparedScene> prepared);
    void retire(std::unique_ptr<ScenePlayback> playback);

    Status status() const;

 private:
    struct Change {
        Scene scene;
        SessionOptions options;
        bool starts_anew = false;
        std::uint64_t number = 0;
    };

    bool idle() const { return !asked_ && !in_work_ && !prepared_.scene; }
    void run();
    std::unique_ptr<PreparedScene> prepare(const Change& change) const;

    double rate_hz_;
    std::function<Playing()> playing_;
    mutable std::mutex mutex_;  ///< of what follows
    std::condition_variable wanted_;
    bool stop_ = false;
    std::optional<Change> asked_;
    std::optional<bool> in_work_;  ///< whether what is being prepared begins anew
    Prepared prepared_;
    std::uint64_t last_number_ = 0;
    std::uint64_t failed_ = 0;
    std::string error_;
    /// Stages end before what makes their frames.
    std::vector<std::unique_ptr<PreparedScene>> spent_;
    std::vector<std::unique_ptr<ScenePlayback>> spent_playbacks_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
