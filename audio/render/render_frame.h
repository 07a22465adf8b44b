#pragma once

#include <cstddef>
#include <vector>

#include "audio/convolution/convolver.h"
#include "audio/render/renderer.h"
#include "audio/spatial/moving_path.h"

namespace aula {

/// The measures that a renderer and the builder of its frames share, worked out from the config.
struct RenderShape {
    RenderShape(const RendererConfig& config, const Hrtf* hrtf);

    ConvolutionShape reverberation;  ///< every source into the ambisonic field
    std::size_t lead_samples;        ///< that the decoder's delay takes off all that passes it
    std::size_t early_taps;          ///< of the filter of an early path
    PathShape path;                  ///< of direct sound and the strongest early paths
    std::size_t moving_paths;        ///< of a source: the direct sound and early ones
    std::size_t longest_delay_samples;
    std::size_t fade_samples;  ///< of an exchange of frames
};

struct RenderFrame::Parts {
    explicit Parts(const RenderShape& shape);

    ConvolutionFilter reverberation;
    std::vector<std::vector<PathSound>> paths;  ///< [source][moving path], the direct sound first
};

}  // namespace aula
