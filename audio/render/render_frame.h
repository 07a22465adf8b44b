#pragma once

#include <cstddef>
#include <vector>

#include "audio/render/renderer.h"
#include "audio/spatial/moving_path.h"
#include "aula/audio/convolver.h"

namespace aula {

/// Dimensions common to a renderer and the builder of its frames, derived from the config.
struct RenderShape {
    RenderShape(const RendererConfig& config, const Hrtf* hrtf);

    ConvolutionShape reverberation;  ///< from the sources to the ambisonic field
    /// Whether all levels of the reverberation change in a step; else the quick ones do. The last
    /// step is whole, and every second one before it.
    bool is_whole(std::size_t step) const { return (steps - 1 - step) % 2 == 0; }

    std::size_t quick_levels;           ///< of the reverberation
    std::size_t quick_samples;          ///< of a response, those that these levels hold
    std::size_t lead_samples;           ///< delay of the decoder, subtracted from all decoded sound
    std::size_t early_taps;             ///< length of the filter of an early path
    PathShape path;                     ///< direct sound and the strongest early paths
    std::size_t path_taps;              ///< of its filter, where they give the levels of octaves
    std::size_t moving_paths;           ///< per source at most: direct sound and early paths
    std::size_t longest_delay_samples;  ///< of a moving path
    std::size_t steps;                  ///< in which the reverberation changes within a frame
    std::size_t fade_samples;           ///< of the reverberation, from step to step
    std::size_t path_fade_samples;      ///< between different paths
};

/// Early paths that move through delay lines, of each of so many sources.
std::size_t moving_early_paths(std::size_t sources);

struct RenderFrame::Parts {
    explicit Parts(const RenderShape& shape);

    std::vector<ConvolutionFilter> reverberation;  ///< [step]
    std::vector<std::vector<PathSound>> paths;  ///< [source][moving path], the direct sound first
};

}  // namespace aula
