#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "apps/room/frames/frame_view.h"
#include "apps/room/frames/room_state.h"
#include "apps/room/frames/sound_at_listener.h"
#include "apps/room/frames/source_trajectory.h"
#include "apps/room/waves/frame_waves.h"
#include "apps/room/waves/wave_synthesis.h"
#include "audio/render/renderer.h"
#include "aula/engine/impulse_response.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene.h"
#include "engine/base/worker_pool.h"

namespace aula {

/// The sound of a source at a listener, with the response that it refers to.
struct HeardSound {
    ImpulseResponse response;
    SourceSound sound;
};

/// Converts poses to the audio thread's input: one propagation step, impulse responses from the
/// energy responses, and a frame of them for the renderer of each listener. [propagation thread]
class FrameMaker {
 public:
    /// The HRTF is needed for binaural output only. Throws InputError if the scene's settings are
    /// invalid.
    FrameMaker(const Scene& scene, const FrameSettings& settings, std::shared_ptr<const Hrtf> hrtf);

    const RendererConfig& config() const { return config_; }

    /// An empty frame with all memory allocated.
    std::unique_ptr<RenderFrame> make_frame() const { return builders_[0]->make_frame(); }

    /// Changes materials from the next frame on, see Propagation.
    void set_object_material(std::size_t object, const Material& material) {
        propagation_.set_object_material(object, material);
        waves_.set_object_material(object, material);
    }
    void change_material(std::size_t material, const Material& coefficients) {
        propagation_.change_material(material, coefficients);
        waves_.change_material(material, coefficients);
    }

    /// Adds and removes sources to match those of a frame; part of fill().
    void take_sources(const std::vector<SourceState>& sources);

    /// Fills one frame per listener with the sound at that listener.
    void fill(const RoomState& room, std::span<const std::unique_ptr<RenderFrame>> frames);

    /// Fills the caches for a room state: propagates up to a window of frames, for at most about
    /// `longest_s`, without output.
    void warm_up(const RoomState& room, double longest_s);

    /// Copies data of the newest frame for display. The caller sets the counters.
    FrameView view(const ViewRequest& request) const;

    double response_length_s() const { return propagation_.response_length_s(); }
    float patch_size_m() const { return propagation_.patch_size_m(); }
    const FrameStatistics& statistics() const { return propagation_.statistics(); }

    /// Rays per source of the newest frame.
    int rays() const { return rays_; }

    /// Positions of the sources in the newest frame.
    const std::vector<Vec3>& source_positions() const { return input_.sources; }

    /// Pose of a listener in the newest frame.
    const Pose& listener(std::size_t index) const { return listeners_[index]; }

    /// The longest delay of the paths of a source, by its id, in the newest frame with it; 0 if it
    /// was in none.
    double longest_delay_s(std::uint64_t id) const;

    /// The sound of a source in the newest frame, by its id; none if it is not in the frame.
    std::optional<HeardSound> sound(std::uint64_t id, std::size_t listener) const;

    /// True if no surface lies between a source, by its id, and a listener in the newest frame.
    bool visible(std::uint64_t id, std::size_t listener) const;

    /// True if anything of a source, by its id, reaches a listener in the newest frame, whatever
    /// its gain.
    bool reaches(std::uint64_t id, std::size_t listener) const;

 private:
    /// A source in the frames.
    struct Voice {
        SourceState state;
        std::unique_ptr<ImpulseResponseBuilder> impulse_responses;
        SourceTrajectory trajectory;
        std::vector<ImpulseResponse> last;   ///< [listener] of one that rings out
        std::vector<EnergyResponse> before;  ///< [listener] frame before; empty: one step
        std::vector<TailScale> scales;       ///< [listener]
    };

    /// Work space of a thread: a synthesis, and the responses of a voice at a listener, [step].
    struct Workspace {
        explicit Workspace(const RendererConfig& config)
            : synthesis(config.sample_rate_hz, config.response_samples),
              steps(frame_steps(config)) {}
        WaveSynthesis synthesis;
        std::vector<ImpulseResponse> steps;
    };

    struct Gains {
        float direct = 1;
        float early = 1;
        float late = 1;
    };

    Voice make_voice(const SourceState& source) const;
    int rays_wanted(const RoomState& room) const;
    void propagate(const RoomState& room);
    bool is_playing(const Voice& voice) const {
        return slot_sources_[voice.state.slot] == voice.state.id;
    }
    void build_response(std::size_t voice, std::size_t listener, ImpulseResponse& response) const;
    void build_steps(std::size_t voice, std::size_t listener, Workspace& workspace);
    void synthesise(WaveSynthesis& synthesis, std::size_t voice, const EnergyResponse& rays,
                    ImpulseResponse& response, TailScale* scale, std::size_t samples) const;
    EnergyResponse between(std::size_t voice, std::size_t listener, float share) const;
    void keep_responses();
    SourceSound sound_of(const Voice& voice, const ImpulseResponse& response) const;

    Simulation simulation_;
    Propagation propagation_;
    RendererConfig config_;
    std::shared_ptr<const NoiseCarriers> carriers_;
    std::vector<std::unique_ptr<RenderFrameBuilder>> builders_;  ///< [listener]
    FrameWaves waves_;
    Medium medium_;
    float speed_of_sound_m_s_;
    FrameInput input_;
    int rays_;            ///< of the newest frame
    double frame_s_ = 0;  ///< computation time of the newest frame
    std::vector<Pose> listeners_;
    std::vector<Voice> voices_;                ///< in the propagation's order
    std::vector<Voice> ringing_;               ///< removed, and still ringing out
    std::vector<std::uint64_t> slot_sources_;  ///< [slot] in the newest frame; 0: none
    Gains gains_;                              ///< of the newest frame
    WorkerPool workers_;
    /// One for each thread: responses are large, and built for a few sources at a time.
    std::vector<std::unique_ptr<Workspace>> workspaces_;
};

}  // namespace aula
