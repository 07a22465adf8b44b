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

/// [pressure, and its gradient along the world axes][wave number]
using WaveSpectra = std::array<std::vector<std::complex<double>>, 4>;

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

    /// The same at s = `shift` + j k: the spectra of the response times exp(-`shift` c t), with the
    /// wave numbers k = i `step`; 0 at k = 0. Shift and step in 1/m. Single precision except for
    /// the constant pressure, which would hide what a high-pass filter leaves.
    WaveSpectra modal(double step, std::size_t count, double shift) const;

    /// The field without the direct sound exp(-j k r) / r. The part of the direct sound that the
    /// modes contain is that of the modes of an unbounded space, with the same taper.
    WaveField reverberant(double wave_number) const;
};

/// 0..1: the share of some octaves, with their limits in 1/m, in the field at a wave number.
double octave_share(double begin, double end, double wave_number);

/// From the modes at both places.
WaveResponse wave_response(const RoomModes& modes, std::span<const OctavePoles> octaves,
                           const ModeValues& source, const ModeValues& receiver);

/// The direct sound exp(-s r) / r at a distance in m, s = j k in 1/m, and its derivative by the
/// distance; nearer than kNearest_m those at this distance.
std::array<std::complex<double>, 2> direct_field(double distance_m, std::complex<double> s);

/// The part of it that modes up to `highest` leave out, real: 2 / (pi r) times the integral of
/// K sin(K r) / (K^2 - k^2) from each wave number of kModeTaper on, in the mean, and its derivative
/// by the distance.
std::array<double, 2> direct_field_beyond(double distance_m, double wave_number, double highest);

/// The integrals of sine and cosine, Si(x) and Ci(x), x above 0.
std::array<double, 2> sine_cosine_integrals(double x);

}  // namespace aula
