#include "audio/render/render_memory.h"

#include <limits>

#include "audio/convolution/partition_levels.h"
#include "audio/convolution/spectral_kernels.h"
#include "audio/dsp/fractional_delay.h"
#include "audio/render/render_frame.h"

namespace aula {

namespace {

constexpr std::size_t kFloat = sizeof(float);

/// Of one input of a convolver: the spectra and windows of its past, and the terms of the sums.
std::size_t convolution_bytes(const ConvolutionShape& shape) {
    std::size_t bytes = 0;
    for (const PartitionLevel& level : partition_levels(shape))
        bytes += (2 * level.count + 3) * level.size * kFloat +
                 3 * kTermsPerPartition * level.count * sizeof(SpectralTerm);
    return bytes;
}

/// Of one moving path, which has two tracks.
std::size_t path_bytes(const PathShape& shape) {
    const std::size_t ear_taps = shape.hrtf != nullptr ? shape.hrtf->taps() : 1;
    const std::size_t point = shape.filter_taps + 3 * ear_taps + 2 * shape.block;
    const std::size_t track = shape.points() * point + shape.filter_taps + 2 * shape.block;
    return sizeof(MovingPath) + (2 * track + shape.block) * kFloat;
}

}  // namespace

std::uint64_t renderer_bytes(const RendererConfig& config, const Hrtf* hrtf,
                             std::size_t listeners) {
    const RenderShape shape(config, hrtf);
    const std::size_t delay_line = shape.longest_delay_samples + 2 * shape.path.filter_taps +
                                   shape.path.block + 3 * kInterpolationTaps;
    const std::uint64_t source_bytes = convolution_bytes(shape.reverberation) +
                                       shape.moving_paths * path_bytes(shape.path) +
                                       delay_line * kFloat;
    constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
    if (config.sources > kLargest / source_bytes / listeners) return kLargest;
    return config.sources * source_bytes * listeners;
}

std::uint64_t equalizer_bytes(const HeadphoneFilter& filter, int block) {
    const ConvolutionShape shape{.block = static_cast<std::size_t>(block), .taps = filter.taps()};
    std::uint64_t bytes = convolution_bytes(shape);
    for (const PartitionLevel& level : partition_levels(shape))  // the spectra of the filter
        bytes += 2 * level.count * level.size * kFloat;
    return filter.ears.size() * bytes;
}

}  // namespace aula
