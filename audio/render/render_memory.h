#pragma once

#include <cstddef>
#include <cstdint>

#include "audio/render/headphones.h"
#include "audio/render/renderer.h"

namespace aula {

/// An estimate of the memory that the constructor of a Renderer allocates, for each of so many
/// listeners. The largest number if it exceeds that. `hrtf` may be null unless the output is
/// binaural.
std::uint64_t renderer_bytes(const RendererConfig& config, const Hrtf* hrtf,
                             std::size_t listeners = 1);

/// An estimate of the memory of a HeadphoneEqualizer.
std::uint64_t equalizer_bytes(const HeadphoneFilter& filter, int block);

}  // namespace aula
