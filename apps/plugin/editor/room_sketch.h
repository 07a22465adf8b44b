#pragma once

#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "apps/plugin/plugin_room.h"
#include "aula/engine/bands.h"
#include "engine/rays/ray_scene.h"

namespace aula::plugin {

/// A scene as an editor draws it.
struct SketchedRoom {
    SketchedRoom(Scene loaded, std::size_t sources)
        : scene(std::move(loaded)), rays(scene), controls(scene, sources) {}

    Scene scene;
    RayScene rays;
    SceneControls controls;
};

/// T30 of a room, s; empty where the decay is not sufficient.
struct ReverberationTimes {
    std::array<std::optional<double>, kBandCount> octaves{};
    std::optional<double> mid;  ///< mean of 500 and 1000 Hz
};

/// Loads the scene of an editor and measures its T30, on a thread of low priority.
class RoomSketch {
 public:
    explicit RoomSketch(std::size_t sources);
    ~RoomSketch();
    RoomSketch(const RoomSketch&) = delete;
    RoomSketch& operator=(const RoomSketch&) = delete;

    /// The scene to show, with source and listener at the places of these controls. The measurement
    /// begins anew when it or a place has changed and stands still.
    void show(const RoomFiles& files, const ControlValues& values);

    /// The newest scene; null until the first one is loaded.
    std::shared_ptr<const SketchedRoom> room() const;
    /// Empty while it is measured.
    std::optional<ReverberationTimes> times() const;
    /// Why the wanted scene is not shown; empty if it is.
    std::string error() const;

 private:
    struct Places {
        Pose source;
        Pose listener;
        friend bool operator==(const Places& a, const Places& b) {
            return a.source.position == b.source.position && a.source.yaw_rad == b.source.yaw_rad &&
                   a.listener.position == b.listener.position;
        }
    };

    void run();
    void load(std::unique_lock<std::mutex>& lock);
    void measure(std::unique_lock<std::mutex>& lock);

    const std::size_t sources_;

    mutable std::mutex mutex_;  ///< of what follows
    std::condition_variable changed_;
    std::optional<RoomFiles> wanted_;
    std::optional<RoomFiles> loaded_;  ///< also one that cannot be read
    std::shared_ptr<const SketchedRoom> room_;
    std::string error_;
    std::optional<Places> places_;
    std::optional<ReverberationTimes> times_;
    bool is_measured_ = false;  ///< the present room at the present places
    bool stop_ = false;

    std::thread thread_;
};

}  // namespace aula::plugin
