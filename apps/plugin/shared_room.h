#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "apps/plugin/plugin_room.h"
#include "apps/room/frames/frame_clock.h"
#include "apps/room/frames/ray_load.h"
#include "apps/room/live/growing_length.h"
#include "apps/room/waves/frame_waves.h"
#include "aula/engine/propagation.h"

namespace aula::plugin {

class GroupVoice;

/// A file as it was when a scene was read from it.
struct FileVersion {
    std::filesystem::path file;
    std::filesystem::file_time_type written{};
    std::uintmax_t bytes = 0;

    auto operator<=>(const FileVersion&) const = default;
};

/// What the instances of a group have in common: the scene file, the seed and the number of the
/// group; of a room also the versions of the files that its scene was read from.
struct GroupKey {
    std::filesystem::path scene;  ///< empty: the default room
    std::optional<std::uint64_t> seed;
    int group = 0;
    std::vector<FileVersion> versions;

    /// Throws InputError if the scene's file cannot be found.
    GroupKey(const RoomFiles& files, int group);

    /// This key with the present versions of the scene file, the meshes and the directivities.
    GroupKey with_versions(const Scene& scene) const;

    /// Whether the files are still as they were for `room`, a key of the same group.
    bool matches(const GroupKey& room) const;

    auto operator<=>(const GroupKey&) const = default;
};

/// A room on the real-time clock for the instances of a group that are heard from one place. It has
/// one propagation with a source for each of them, so that they share geometry, patches and rays,
/// and one propagation thread. The listener's place is that of most instances; an instance whose
/// listener stays elsewhere is told to leave for another room.
class SharedRoom : private LiveFrames {
 public:
    /// The room of a group for an instance with these controls: the present one for the place of
    /// its listener, or a new one. `load` returns the scene if the group has no room yet, or only
    /// rooms of other versions of its files. The room ends with its last owner. Throws what `load`
    /// throws, and InputError.
    static std::shared_ptr<SharedRoom> join(const GroupKey& key, const ControlValues& values,
                                            const std::function<Scene()>& load);

    ~SharedRoom() override;
    SharedRoom(const SharedRoom&) = delete;
    SharedRoom& operator=(const SharedRoom&) = delete;

    const Scene& scene() const { return scene_; }
    double response_length_s() const { return propagation_->response_length_s(); }

    /// Adds an instance and waits until it is heard, at most a few seconds. Rethrows an exception
    /// of the propagation. [not the audio thread]
    void add(GroupVoice& voice);
    /// Removes it. Waits for the frame in progress. [not the audio thread]
    void remove(GroupVoice& voice);

 private:
    /// How another room of the group sees this one.
    struct Entry {
        std::mutex mutex;
        Vec3 place{0};
        bool open = true;  ///< false after a failure, or if the length is to change
        std::uint64_t number = 0;
        std::weak_ptr<SharedRoom> room;
    };
    struct Register;

    /// The right to change the instances between two frames. Without it a thread would hardly get
    /// the mutex while all frames are late.
    class Turn;

    /// `other`: a room of the group, or null.
    SharedRoom(const GroupKey& key, Scene scene, const Vec3& place, const SharedRoom* other);

    static Register& all();

    void build();
    void run();
    bool wait_until(FrameClock::Clock::time_point time) override;
    bool publish_frame(FrameClock& clock) override;
    double compute_frame(FrameClock& clock) override;
    bool compute(double time_s);
    void make_way();
    void choose_place();
    bool has_older_twin() const;

    const GroupKey key_;
    const Scene scene_;
    const std::shared_ptr<Entry> entry_;
    const std::shared_ptr<GrowingLength> length_;  ///< of all rooms of the group
    const std::shared_ptr<void> measured_;         ///< GrowingLength::hear()
    std::optional<double> room_length_s_;          ///< room_length_s() of the scene

    std::atomic<int> waiting_ = 0;  ///< turns that have not begun or not ended

    std::mutex mutex_;  ///< of what follows, locked while a frame is computed
    std::condition_variable changed_;
    std::condition_variable heard_;
    std::optional<Propagation> propagation_;
    FrameWaves waves_;
    std::vector<GroupVoice*> voices_;  ///< in the order of their sources
    std::vector<RigidTransform> objects_;
    Vec3 place_;
    int rays_ = 0;
    RayLoad load_;
    int reported_rays_ = 0;  ///< the last report
    int reported_wanted_ = 0;
    double took_s_ = 0;                      ///< to compute the last frame
    int still_frames_ = 0;                   ///< frames since the listener has moved
    FrameClock::Clock::time_point moved_{};  ///< when it has
    bool makes_way_ = false;                 ///< all instances leave
    std::exception_ptr failure_;
    bool stop_ = false;

    std::thread thread_;
};

}  // namespace aula::plugin
