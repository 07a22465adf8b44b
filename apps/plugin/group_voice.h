#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "apps/plugin/control_snapshot.h"
#include "apps/plugin/plugin_room.h"
#include "apps/plugin/shared_room.h"
#include "apps/room/auralizer/room_renderer.h"
#include "apps/room/frames/source_trajectory.h"
#include "apps/room/waves/wave_synthesis.h"
#include "audio/render/renderer.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"

namespace aula::plugin {

/// The room of an instance of a group: a source of a shared room and its renderer.
class GroupVoice final : public PluginRoom {
 public:
    /// The frames follow `controls`. `leave` is called once, on the propagation thread, when the
    /// instance has to leave for another room; `report` like that of OwnRoom. Waits until a frame
    /// is heard. Throws InputError.
    GroupVoice(std::shared_ptr<SharedRoom> room, const PluginPorts& ports,
               std::shared_ptr<const ControlSnapshot> controls, std::function<void()> leave,
               ReportRays report);
    ~GroupVoice() override;

    void render(std::span<const float* const> inputs, std::span<float* const> outputs,
                int samples) override;
    std::int64_t tail_samples() const override { return tail_samples_.load(); }

    // [propagation thread]
    /// Takes the newest values of the controls.
    void read_controls();
    /// The same for a frame at a time of the room, in s.
    void begin_frame(double time_s);
    std::size_t sources() const { return places_.sources(); }
    Pose source(std::size_t index) const { return places_.source_pose(values_, index); }
    Vec3 listener() const { return places_.listener_pose(values_).position; }
    int rays() const { return places_.rays(values_); }
    /// What reaches the listener from a source.
    struct Arriving {
        const EnergyResponse* energy = nullptr;
        std::optional<PairWaves> modes;  ///< of the room, or none
    };
    /// Prepares a frame from that of each source, which publish() hands to the renderer.
    void prepare(std::span<const Arriving> arriving);
    void publish();
    bool is_heard() const { return heard_; }
    void leave();
    void report_rays(int rays, int wanted) const { report_(rays, wanted); }

    /// Successive frames in which the listener was not in the place of the room.
    int frames_elsewhere = 0;

 private:
    struct Dimensions {
        RendererConfig config;
        std::shared_ptr<const Hrtf> hrtf;
    };
    GroupVoice(std::shared_ptr<SharedRoom> room, const Dimensions& dimensions,
               std::shared_ptr<const ControlSnapshot> controls, std::function<void()> leave,
               ReportRays report);
    static Dimensions dimensions(const SharedRoom& room, const PluginPorts& ports);

    const std::shared_ptr<SharedRoom> room_;
    const SceneControls places_;
    const std::shared_ptr<const ControlSnapshot> controls_;
    const std::function<void()> leave_;
    const ReportRays report_;
    const double speed_of_sound_m_s_;
    const double rate_hz_;

    // Used by the propagation thread.
    ControlValues values_;
    std::vector<SourceTrajectory> trajectories_;     ///< [source]
    std::vector<ImpulseResponseBuilder> responses_;  ///< [source]
    WaveSynthesis synthesis_;
    RenderFrameBuilder frames_;
    std::unique_ptr<RenderFrame> prepared_;
    double longest_delay_s_ = 0;
    bool heard_ = false;
    bool leaves_ = false;

    std::atomic<std::int64_t> tail_samples_;

    // Used by the audio thread.
    const std::size_t block_;
    RoomRenderer renderer_;
    Pose head_pose_;
    std::vector<float*> outputs_;
};

}  // namespace aula::plugin
