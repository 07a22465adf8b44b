#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/bands.h"
#include "engine/base/time_bins.h"
#include "engine/scene/scene.h"

namespace aula {

/// One discrete arrival at the listener: the direct sound or an image source.
struct SpecularPath {
    int order = 0;       ///< reflections; 0 is the direct sound
    float length_m = 0;  ///< from source to listener
    Vec3 direction{0};   ///< unit, world axes, from the listener towards where the sound comes from
    Bands energy;        ///< fluence in 1/m2 per unit emitted energy, air and walls included
    std::uint64_t id = 0;  ///< of the image source, the same in every frame; 0: direct
};

/// The energy response (echogram) of one source at one listener: fluence in 1/m2 per unit emitted
/// energy. What the estimators find is binned; direct sound and image sources stay discrete.
struct EnergyResponse {
    TimeBins bins;
    float speed_of_sound_m_s = 343.2F;
    std::vector<Bands> energy;    ///< [bin], everything but `paths`
    std::vector<Vec3> direction;  ///< [bin] sum over arrivals and bands of energy times the unit
                                  ///< direction it comes from; its length over the bin's energy
                                  ///< is 1 for one direction and 0 for a diffuse field
    std::vector<SpecularPath> paths;  ///< by ascending length

    /// When a path arrives, in s after emission.
    double arrival_s(const SpecularPath& path) const {
        return double{path.length_m} / double{speed_of_sound_m_s};
    }

    /// Energy of a band with the discrete paths, from 0 to the end. 1/m2
    double total(std::size_t band) const;

    /// Energy per uniform bin of `width_s` from 0 to the response's length, discrete paths
    /// included, energy uniform in time inside each of our bins: [uniform bin]. 1/m2
    std::vector<Bands> uniform(double width_s) const;
};

}  // namespace aula
