#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "apps/room/frames/live_load.h"
#include "apps/room/live/change_preparer.h"
#include "apps/room/live/live_mixer.h"
#include "apps/room/live/player.h"
#include "apps/room/live/prepared_scene.h"

namespace aula {

/// What plays, and the threads that change it. Player gives it the user's wishes.
struct Player::State {
    using Clock = std::chrono::steady_clock;

    State(const Scene& scene, const PlaybackOptions& options);
    ~State();

    void build(const Scene& scene, const PlaybackOptions& options);
    void open_device(const PlaybackOptions& options);
    void fade_out();
    bool follow_rate(double device_hz);

    void start();
    bool begin(std::unique_ptr<PreparedScene> prepared, std::uint64_t number);
    bool begin_at_other_rate(std::unique_ptr<PreparedScene> prepared, std::uint64_t number);
    Reusable reusable();
    RoomState state_of(const PreparedScene& next);
    void take_next();
    void switch_to_next();
    void take_first(const FrameMaker& maker);
    void note_begun(const FrameMaker& maker);
    void before_frame(double time_s);
    void after_frame(const FrameMaker& maker, double spare_s);
    void take_frame(const FrameMaker& maker);
    void keep_up(double took_s);
    std::optional<double> other_length_s(double took_s);
    void show(const FrameMaker& maker, double spare_s);

    AuralizerStatus frames_so_far() const;
    PlayStatus status_so_far() const;
    bool rays_fall(const PreparedScene& prepared) const;
    PlayControls controls_of(const PreparedScene& prepared, const LiveLoad& with) const;
    LiveLoad load_of(const PreparedScene& prepared) const;
    void place_listener(const Pose& pose);
    void take_controls(PlayControls next);
    PoseLatency latency(double frame_period_ms) const;

    std::vector<std::string> warnings;
    LatencyCounts compute_time;

    std::mutex mutex;  ///< protects the following members
    double rate_hz = 0;
    double device_rate_hz = 0;                ///< another one while a change to it is prepared
    std::optional<double> requested_rate_hz;  ///< of that change
    /// The preparing thread exchanges both, while no device calls them, and reads them without the
    /// lock.
    std::unique_ptr<LiveAuralizer> auralizer;
    std::unique_ptr<LiveMixer> mixer;
    bool exchanges_auralizer = false;  ///< the preparing thread is about to
    bool stop = false;
    std::unique_ptr<PreparedScene> playing;   ///< the auralizer's thread reads it without the lock
    std::unique_ptr<PreparedScene> next;      ///< until its first frame
    std::uint64_t next_change = 0;            ///< number of the change to it
    std::unique_ptr<PreparedScene> replaced;  ///< until the preparing thread destroys it
    PlayControls controls;
    PlayStatus status;        ///< of the newest frame, and the audible change
    AuralizerStatus earlier;  ///< frames and times of auralizers of other rates
    std::optional<ViewRequest> request;
    std::shared_ptr<const FrameView> view;
    Clock::time_point shown;                   ///< when the last view was made
    std::optional<LiveLoad> load;              ///< of what plays
    std::optional<double> longest_response_s;  ///< with which frames are in time; empty: any

    // Destroyed before the mixer that they use, also if the constructor throws.
    std::unique_ptr<Monitor> monitor;
    std::unique_ptr<AudioDevice> device;
    std::unique_ptr<ChangePreparer> changes;
};

}  // namespace aula
