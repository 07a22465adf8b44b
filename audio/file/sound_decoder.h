#pragma once

#include <cstddef>
#include <functional>
#include <span>

namespace aula {

/// Decodes a sound file with libsndfile and writes a SoundHeader and the blocks of samples, until
/// `write` returns false. The decoders may crash and loop on malformed files: only in a
/// ContainedProcess.
void decode_sound(std::span<const std::byte> file,
                  const std::function<bool(const void* bytes, std::size_t size)>& write);

}  // namespace aula
