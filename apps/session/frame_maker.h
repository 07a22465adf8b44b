#pragma once

#include <memory>
#include <vector>

#include "audio/renderer.h"
#include "engine/impulse_response.h"
#include "engine/propagation.h"
#include "engine/scene.h"

namespace aula {

/// The way from poses to what the audio thread needs: one propagation step, the energy responses
/// turned into impulse responses, those into a frame for the renderer. [propagation thread]
class FrameMaker {
 public:
    /// Keeps a reference to the scene. The HRTF is needed for binaural output only. Throws Error if
    /// the scene's settings cannot be used.
    FrameMaker(const Scene& scene, double sample_rate_hz, int block, OutputFormat output,
               std::shared_ptr<const Hrtf> hrtf);

    const RendererConfig& config() const { return config_; }

    /// An empty frame with all memory in place.
    std::unique_ptr<RenderFrame> make_frame() const { return builder_.make_frame(); }

    /// Fills a frame with what is heard at a time, the sources on their paths.
    void fill(double time_s, const Pose& listener, RenderFrame& frame);

    double response_length_s() const { return propagation_.response_length_s(); }
    const FrameStatistics& statistics() const { return propagation_.statistics(); }

 private:
    const Scene& scene_;
    Propagation propagation_;
    ImpulseResponseBuilder impulse_responses_;
    RendererConfig config_;
    RenderFrameBuilder builder_;
    FrameInput input_;
    std::vector<ImpulseResponse> responses_;  ///< one for each source
    std::vector<SourceSound> sounds_;
};

}  // namespace aula
