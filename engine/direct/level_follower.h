#pragma once

#include <array>

#include "aula/engine/bands.h"
#include "aula/engine/scene.h"

namespace aula {

/// The energies of the direct sound of a source and a listener, which follow those of the model
/// with a bounded change of level per metre walked. The sum over paths is continuous where the next
/// order of diffraction continues a path. It has steps where that order is beyond the limits of the
/// search, where a path over one jamb of a door passes the end of the other, and where the edges of
/// its leaf meet those of its frame; the follower turns them into slopes. While it follows, a level
/// depends on where the walk came from; at rest it becomes that of the model. Levels are relative
/// to free field over the straight distance, so that walking towards a source is not slowed down.
class LevelFollower {
 public:
    /// Octaves may change by as much per metre walked, dB: three quarters of the largest change
    /// past a single opening or a wall's end that tests allow, 0.2 dB (63 Hz) to 1.2 dB (8 kHz) per
    /// centimetre. Behind a door the exact field changes half as much.
    static constexpr std::array<double, kBandCount> kSlope_db_m{15, 15, 15, 22.5, 30, 37.5, 60, 90};

    /// The energies of a frame for those of the model, both in 1/m2. Ends that jump
    /// (limits::kJump_m) and the first frame have those of the model. Steps of more than 10 dB need
    /// half a metre. At rest, and where `has_moved` says that an object has moved, the pressure
    /// moves half-way in each frame.
    const Bands& follow(const Vec3& source, const Vec3& listener, const Bands& model,
                        bool has_moved);

    /// The energies of the last frame.
    const Bands& energy() const { return energy_; }

    /// Whether the energies were those of the model, to the bit, in the last frame.
    bool is_exact() const { return is_exact_; }

 private:
    bool is_first_ = true;
    bool is_exact_ = true;
    Bands energy_;
    Vec3 source_{0};
    Vec3 listener_{0};
    std::array<double, kBandCount> levels_db_{};  ///< relative to free field
};

}  // namespace aula
