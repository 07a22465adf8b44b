#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/scene.h"
#include "aula/engine/time_bins.h"

namespace aula {

/// A discrete arrival at the listener: the direct sound or a specular reflection (image source).
struct SpecularPath {
    int order = 0;         ///< number of reflections; 0 is the direct sound
    float length_m = 0;    ///< from source to listener
    Vec3 direction{0};     ///< unit, world axes, of arrival: from the listener to the image source
    Bands energy;          ///< fluence in 1/m2 per unit emitted energy, air and walls included
    std::uint64_t id = 0;  ///< identifies the image source in all frames; 0: direct
};

/// The energy response (echogram) of one source at one listener: fluence in 1/m2 per unit emitted
/// energy. Diffuse energy is binned in time; direct sound and image sources are discrete.
struct EnergyResponse {
    TimeBins bins;
    float speed_of_sound_m_s = 343.2F;
    std::vector<Bands> energy;    ///< [bin], without `paths`
    std::vector<Vec3> direction;  ///< [bin] sum over arrivals and bands of energy times the unit
                                  ///< direction of arrival; its length re the bin's energy is 1
                                  ///< for one direction and 0 for a diffuse field
    std::vector<SpecularPath> paths;  ///< by ascending length

    /// Time of arrival of a path, s after the emission.
    double arrival_s(const SpecularPath& path) const {
        return double{path.length_m} / double{speed_of_sound_m_s};
    }

    /// Total energy of a band including the discrete paths, 1/m2.
    double total(std::size_t band) const;

    /// The response including the discrete paths in uniform bins of `width_s`, 1/m2: [uniform bin].
    /// The energy of each original bin is distributed uniformly over its duration.
    std::vector<Bands> uniform(double width_s) const;
};

}  // namespace aula
