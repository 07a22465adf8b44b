#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/direct/edge_paths.h"

namespace aula {

/// The taps of coherent paths of a source and a listener by ascending length, and that of the sound
/// through walls if there is one, with energies that follow those of the paths; see EdgePaths::taps
/// and LevelFollower. `model` is the mean energy of all without the directivity of the source,
/// `has_moved` that of LevelFollower::follow. The taps of the last frame, memory.taps, fade out
/// where all paths have vanished; the caller updates them. Empty for a straight path without edges.
std::vector<SoundPath> followed_taps(const EdgePaths& edge_paths, std::span<const EdgePath> paths,
                                     const Bands& model, const Vec3& source, const Vec3& listener,
                                     bool has_moved, TapMemory& memory,
                                     const std::optional<SoundPath>& through_walls = {});

}  // namespace aula
