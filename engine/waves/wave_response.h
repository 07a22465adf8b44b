#pragma once

#include <array>
#include <complex>
#include <span>
#include <vector>

#include "aula/engine/vec3.h"
#include "engine/waves/mode_values.h"
#include "engine/waves/wall_damping.h"

namespace aula {

/// Transfer functions of the pressure, and of its gradient in 1/m along the world axes.
using WaveField = std::array<std::complex<double>, 4>;

/// The field at a receiver of a source with amplitude 1 at 1 m in free field, as sums of poles.
struct WaveResponse {
    /// The poles of a room and their residues, which give the field in some octaves.
    struct Octaves {
        double begin = 0;                         ///< 1/m
        double end = 0;                           ///< 1/m
        std::vector<std::complex<double>> poles;  ///< 1/m, s = j k; without the conjugates
        std::vector<WaveField> residues;          ///< [pole]
    };

    std::vector<Octaves> octaves;    ///< ascending
    double highest_wave_number = 0;  ///< 1/m; of the modes
    Vec3 from_source{0};             ///< the vector from the source to the receiver, m

    /// The field of the modes at a wave number in 1/m above 0. About the edge of two octaves it is
    /// faded from one to the other.
    WaveField modal(double wave_number) const;

    /// The field without the direct sound exp(-j k r) / r. The part of the direct sound that the
    /// modes contain is that of the modes of an unbounded space up to the same wave number.
    WaveField reverberant(double wave_number) const;
};

/// From the modes at both places.
WaveResponse wave_response(const RoomModes& modes, std::span<const OctavePoles> octaves,
                           const ModeValues& source, const ModeValues& receiver);

/// The direct sound exp(-j k r) / r at a distance in m, and its derivative by the distance; nearer
/// than kNearest_m those at this distance.
std::array<std::complex<double>, 2> direct_field(double distance_m, double wave_number);

/// The part of it that modes above `highest` carry, real: 2 / (pi r) times the integral of
/// K sin(K r) / (K^2 - k^2) from `highest` > k on.
std::array<double, 2> direct_field_beyond(double distance_m, double wave_number, double highest);

/// The integrals of sine and cosine, Si(x) and Ci(x), x > 0.
std::array<double, 2> sine_cosine_integrals(double x);

}  // namespace aula
