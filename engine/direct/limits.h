#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/edges/edge_field.h"
#include "engine/edges/wedge_integral.h"

/// Limits that the kinds of paths around edges share, and how fields fade out towards them: a path
/// that is left out changes nothing at that place.
namespace aula::limits {

// Detours.

/// Longest detour of a path. A choice: at this detour a half plane leaves -22 dB of free field at
/// 63 Hz and -42 dB at 8 kHz. A longer one adds edges to each search.
inline constexpr double kLongestDetour_m = 15;

/// Longest detour over an edge that leaves the straight line free: two wavelengths of the lowest
/// band. The field of a half plane is 21 dB below the straight path there.
inline constexpr double kLongestLitDetour_m = 11;

/// Longest detour over an edge of a chain that its neighbours see past. A choice: there the chain
/// is 16 dB below the path without that edge at 63 Hz, and 31 dB at 4 kHz.
inline constexpr double kLongestLitBend_m = 2;

inline constexpr double longest_detour_m(bool is_lit) {
    return is_lit ? kLongestLitDetour_m : kLongestDetour_m;
}

/// The weight of a field by a value that has a limit: 1 up to three quarters of the limit, from
/// there falling to 0.
inline double before_limit(double value, double limit) {
    return smooth_step(4 * (1 - value / limit));
}

// Levels.

/// Levels above that at which a path is left out by which its field fades in: a factor of 2 in
/// pressure. A choice: over less, a passing path would be heard as a step.
inline constexpr double kFade_db = 6;

/// The weight of a path by its level above that at which paths are left out.
inline double above_threshold(double above_db) { return smooth_step(above_db / kFade_db); }

/// A path as far below the strongest between the same points, or a level as far below free field,
/// is silent. A choice: the range of a reverberation time.
inline constexpr double kSilence_db = -60;

/// Taps as far below all that is heard are left out. A choice: 0.0004 dB of the energy each.
inline constexpr double kWeakestTap_db = -40;
static_assert(kWeakestTap_db > kSilence_db);

/// The band of estimated levels, 500 Hz: the middle of the octaves of speech.
inline constexpr std::size_t kEstimated = 3;

/// Free field over the field behind a half plane, by a detour, in the band of estimates: a fit
/// within 1.5 dB, 2 + 4.8 sqrt(N) with N = 2 detour / lambda.
inline double half_plane_loss(double detour_m, const WedgeIntegral& integral) {
    const double n = integral.wave_number_per_m(kEstimated) * detour_m / std::numbers::pi;
    return 2 + 4.8 * std::sqrt(n);
}

// Bends and movements.

/// Bends up to this angle are grazing in part, from 0 on. A choice: at an edge 1 m away they occupy
/// the last 10 cm of a walk out of its shadow.
inline constexpr double kSharpBend_rad = 0.1;

/// Movement of an end in a frame beyond which it has jumped: 7.5 m/s at 30 frames per second,
/// faster than listeners walk and run.
inline constexpr float kJump_m = 0.25F;

/// Movement of an end after which the edges and planes near a pair are selected anew. A choice: a
/// selection of edges reaches farther by what it may miss until then, and a walk of 1.5 m/s needs
/// six a second.
inline constexpr double kSelectAnew_m = 0.25;

/// Movement of an end after which chains are searched anew. A choice: a search may take several
/// frames, and a walk of 1.5 m/s moves 5 cm in each.
inline constexpr float kSearchAnew_m = 0.1F;

}  // namespace aula::limits
