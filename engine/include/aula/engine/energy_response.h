#pragma once

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/direction_moments.h"
#include "aula/engine/scene.h"
#include "aula/engine/time_bins.h"

namespace aula {

/// A discrete arrival at the listener: direct sound or a specular reflection (image source). The
/// direct sound and its diffraction at edges are several paths of order 0. Path 0 is the straight
/// one or, in the shadow, the strong one of the smallest length; the energies of all add up to the
/// direct sound. What walls transmit of the straight path is one more path of order 0.
struct SoundPath {
    /// How the sound comes to the listener.
    enum class Kind : std::uint8_t {
        direct,        ///< the straight path, which nothing blocks
        image,         ///< the straight path from an image source
        bent,          ///< around edges; a reflection before or after them counts in `order`
        through_walls  ///< the straight path through walls that transmit
    };

    Kind kind = Kind::direct;  ///< how the sound comes to the listener
    int order = 0;             ///< number of reflections; 0: direct sound
    float length_m = 0;        ///< length of the path from the source to the listener
    /// Unit vector from the listener to the image source or edge, world axes; shorter, in
    /// proportion to the distance, within 0.1 m.
    Vec3 direction{0};
    Bands energy;  ///< fluence in 1/m2 per unit emitted energy, with losses of air and walls
    /// Paths of successive frames that have the same key are heard as one that moves; one with a
    /// new key fades in. The main path has a new key where it jumps to a distant path.
    std::uint64_t key = 0;
    bool is_main = false;  ///< the main path of the direct sound, straight or bent
    int edges = 0;         ///< number of edges that the path bends around; 0: none
    Vec3 departure{0};     ///< in which the sound leaves the source, as `direction`
    /// Where it bends, from the source to the listener, world axes, m.
    std::vector<Vec3> apexes{};
};

/// Squared pressure of a fluence, p^2 = 4 pi I: 1 at 1 m from a source of unit energy in free
/// field.
template <typename Real>
constexpr Real squared_pressure(Real fluence) {
    return 4 * std::numbers::pi_v<Real> * fluence;
}

/// The energy response (echogram) of one source at one listener: fluence in 1/m2 per unit emitted
/// energy. In a free field it is 1 / (4 pi r^2) at the distance r from an omnidirectional source,
/// times Directivity::factor for others. Time 0 is the emission. Direct sound and image sources are
/// discrete paths; all other energy is sorted into time bins.
struct EnergyResponse {
    TimeBins bins;                      ///< time axis of `energy` and `directions`
    float speed_of_sound_m_s = 343.2F;  ///< converts lengths of paths to times
    Vec3 listener{0};                   ///< its position, world axes, m
    std::uint64_t room = 0;             ///< a hash of the scene's geometry
    std::vector<Bands> energy;          ///< [bin] without `paths`
    /// [bin] Of the sound without `paths`. Sums over arrivals and octave bands: each direction
    /// counts with the energy of all bands.
    std::vector<DirectionMoments> directions;
    /// Discrete paths by ascending length. Paths that arrive after the last bin are included.
    std::vector<SoundPath> paths;

    /// A response without energy.
    static EnergyResponse silent(const TimeBins& bins, float speed_of_sound_m_s = 343.2F);

    /// Sets energies and directions of all bins to zero; `paths` remain.
    void clear_bins();

    /// Adds the energy of a path of that length, and its directions, to the bin of its arrival.
    /// After the last bin nothing is added.
    void add(double length_m, const Bands& arrived, const DirectionMoments& arrived_directions) {
        const std::size_t bin = bins.index(length_m / double{speed_of_sound_m_s});
        if (bin >= bins.count()) return;
        energy[bin] += arrived;
        directions[bin] += arrived_directions;
    }

    /// Time of arrival of a path in s after the emission.
    double arrival_s(const SoundPath& path) const {
        return double{path.length_m} / double{speed_of_sound_m_s};
    }

    /// Total energy of a band in 1/m2, including the discrete paths that arrive within the bins.
    double total(std::size_t band) const;

    /// The response in uniform bins of `width_s` > 0, [uniform bin] in 1/m2, including the discrete
    /// paths. The energy of each original bin is distributed over its duration with the slope of
    /// its neighbours' energies, band by band.
    std::vector<Bands> uniform(double width_s) const;
};

}  // namespace aula
