#pragma once

#include <memory>
#include <vector>

#include "apps/session/base/session_options.h"
#include "apps/session/frames/frame_view.h"
#include "apps/session/frames/play_controls.h"
#include "audio/render/renderer.h"
#include "engine/propagation.h"
#include "engine/response/impulse_response.h"
#include "engine/scene/scene.h"

namespace aula {

/// The way from poses to what the audio thread needs: one propagation step, the energy responses
/// turned into impulse responses, those into a frame for the renderer. [propagation thread]
class FrameMaker {
 public:
    /// Keeps a reference to the scene. The HRTF is needed for binaural output only. Throws Error if
    /// the scene's settings cannot be used. Of the options block, output and order are used.
    FrameMaker(const Scene& scene, double sample_rate_hz, const SessionOptions& options,
               std::shared_ptr<const Hrtf> hrtf);

    const RendererConfig& config() const { return config_; }

    /// An empty frame with all memory in place.
    std::unique_ptr<RenderFrame> make_frame() const { return builder_.make_frame(); }

    /// Fills a frame with what is heard at a time: the listener and the sources on their paths, or
    /// where and as the controls say.
    void fill(double time_s, const PlayControls& controls, RenderFrame& frame);

    /// Fills the caches with what a frame at that time finds: propagates up to a window of frames,
    /// for not much longer than a time, and plays none.
    void warm_up(double time_s, const PlayControls& controls, double longest_s);

    /// Copies what is to be looked at of the newest frame. Counts are left to the caller.
    FrameView view(const ViewRequest& request) const;

    double response_length_s() const { return propagation_.response_length_s(); }
    const FrameStatistics& statistics() const { return propagation_.statistics(); }

    /// Rays per source of the newest frame.
    int rays() const { return rays_; }

    /// Where the sources were in the newest frame.
    const std::vector<Vec3>& source_positions() const { return input_.sources; }

 private:
    int rays_wanted(const PlayControls& controls) const;
    void propagate(double time_s, const PlayControls& controls);
    SourceSound sound_of(std::size_t source, const PlayControls& controls);

    const Scene& scene_;
    Propagation propagation_;
    RendererConfig config_;
    std::vector<ImpulseResponseBuilder> impulse_responses_;  ///< one for each source
    RenderFrameBuilder builder_;
    FrameInput input_;
    int rays_;            ///< of the newest frame
    double frame_s_ = 0;  ///< that the newest frame took
    Pose listener_;
    std::vector<ImpulseResponse> responses_;  ///< one for each source
    std::vector<SourceSound> sounds_;
};

}  // namespace aula
