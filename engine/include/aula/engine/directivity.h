#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aula/engine/bands.h"
#include "aula/engine/vec3.h"

namespace aula {

/// The directivity of a source: the energy that it radiates in a direction, relative to an
/// omnidirectional source of the same power. Directions are in the local axes of the source: x to
/// the front, y to the left, z up. In each octave band the mean over all directions is 1: a
/// directivity distributes the power and does not change it. Copies share their data.
class Directivity {
 public:
    /// Omnidirectional.
    Directivity();

    /// A pattern of the pressure a + (1 - a) cos(angle to the front), 0 <= a <= 1, in all bands. a
    /// is 1 for an omnidirectional pattern, 0.5 for a cardioid, 0 for a figure of eight.
    static Directivity first_order(float omnidirectional_share);

    /// The far field of a cap that vibrates in a rigid sphere, in air of 20 degrees Celsius. The
    /// cap is at the front; its edge is seen from the sphere's centre at `half_angle_rad` from the
    /// front, above 0, below pi.
    static Directivity vibrating_cap(float sphere_radius_m, float half_angle_rad);

    /// A table of energies on any scale, `energy` [elevation * azimuths + azimuth]. Elevations are
    /// at equal steps from -90 to 90 degrees, azimuths at equal steps from 0 to the left. Between
    /// them the energy is interpolated by cubic polynomials. The mean of a row at a pole counts.
    /// Throws InputError unless there are at least 3 elevations and an even number of at least 4
    /// azimuths, all energies are finite and at least 0, and each band has energy.
    static Directivity table(std::size_t elevations, std::size_t azimuths,
                             std::vector<Bands> energy);

    /// A directivity that ships, by its name; empty if there is none of that name.
    static std::optional<Directivity> find(const std::string& name);

    /// The names of all that ship: omni, subcardioid, cardioid, supercardioid, figure_of_eight,
    /// talker and loudspeaker.
    static std::vector<std::string> names();

    /// True if the factor is 1 in all directions.
    bool is_omnidirectional() const { return pattern_ == nullptr; }

    /// Energy in a direction, a unit vector in local axes, over that of an omnidirectional source.
    /// A shorter vector, that of a near receiver, blends linearly to the mean over all
    /// directions, 1.
    Bands factor(const Vec3& direction) const;

    /// Level to the front in dB, relative to an omnidirectional source.
    Bands on_axis_db() const;

 private:
    class Pattern;
    class FirstOrder;
    class Axial;
    class Table;
    explicit Directivity(std::shared_ptr<const Pattern> pattern);

    std::shared_ptr<const Pattern> pattern_;  ///< null: omnidirectional
};

/// Reads a directivity from a file: SOFA (FreeFieldDirectivityTF) if its name ends in ".sofa", else
/// a table in JSON (docs/scene_format.md). Throws InputError if it cannot be read.
Directivity load_directivity(const std::filesystem::path& file);

}  // namespace aula
