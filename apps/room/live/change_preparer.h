#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/room/frames/room_state.h"
#include "apps/room/live/prepared_scene.h"

namespace aula {

/// Prepares the next playback on a separate thread during playback. Of several requests the newest
/// is prepared.
class ChangePreparer {
 public:
    struct Status {
        bool preparing = false;    ///< a requested change has neither begun nor failed
        std::uint64_t failed = 0;  ///< changes that could not be prepared
        std::string error;         ///< why the last one failed; empty if it did not
    };

    /// Functions of the player, which the thread calls without holding a lock.
    struct Hooks {
        /// Data of the present playback.
        std::function<Reusable()> reusable;
        /// The state in which a prepared scene would begin now.
        std::function<RoomState(const PreparedScene&)> state;
        /// Begins to play a prepared change, and calls set_begun() when it has begun. Returns false
        /// if the change has to be prepared again, for another sample rate.
        std::function<bool(std::unique_ptr<PreparedScene>, std::uint64_t number)> begin;
    };

    ChangePreparer(double sample_rate_hz, Hooks hooks);
    ~ChangePreparer();
    ChangePreparer(const ChangePreparer&) = delete;
    ChangePreparer& operator=(const ChangePreparer&) = delete;

    /// Prepares all later requests at another sample rate. [any thread]
    void set_sample_rate(double sample_rate_hz);

    /// Requests a scene. It replaces an earlier request that is not being prepared yet; if that one
    /// or the one in preparation was to begin anew, this one does. Returns its number (>= 1). [any
    /// thread]
    std::uint64_t request(Scene scene, PlaybackOptions options, bool starts_anew);

    /// The same for a scene that continues. Returns 0 and does nothing if a change is being
    /// prepared. [any thread]
    std::uint64_t request_if_idle(Scene scene, PlaybackOptions options);

    /// Notes that the change in preparation has begun: later requests continue it. [any thread,
    /// during Hooks::begin]
    void set_begun();

    /// Ends the thread; no change begins afterwards. [the owner's thread]
    void stop();

    Status status() const;

 private:
    struct Change {
        Scene scene;
        PlaybackOptions options;
        bool starts_anew = false;
        std::uint64_t number = 0;
    };

    bool idle() const { return !requested_ && !preparing_; }
    void run();
    bool make(const Change& change);

    Hooks hooks_;
    mutable std::mutex mutex_;  ///< protects the following members
    double rate_hz_;            ///< of requests
    std::condition_variable wakeup_;
    bool stop_ = false;
    std::optional<Change> requested_;
    bool preparing_ = false;
    bool preparing_anew_ = false;  ///< the change in preparation is to begin anew and has not yet
    std::uint64_t last_number_ = 0;
    std::uint64_t failed_ = 0;
    std::string error_;
    std::thread thread_;  ///< started last
};

}  // namespace aula
