#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "aula/engine/directivity.h"
#include "engine/scene/directivity_answer.h"

namespace aula {

/// Measured squared pressures around a source.
struct DirectivityMeasurements {
    std::vector<std::array<double, 3>> positions;  ///< [direction] m, axes of the source
    std::vector<double> frequencies_hz;
    std::vector<double> energies;  ///< [direction * frequencies + frequency]
};

/// The directivity of measurements. In an octave band it is the mean of the frequencies in it, or
/// that of the nearest band with frequencies. Energies are scaled to one distance. Throws
/// InputError if values are not finite, no frequency is in any band, or a position is the source.
Directivity directivity_of(const DirectivityMeasurements& measurements);

/// The directivity of a usable answer of the program that reads SOFA, with the same errors; also if
/// the axes of the source are not two directions.
Directivity directivity_of(const DirectivityAnswer& answer);

/// Reads a SOFA file (FreeFieldDirectivityTF) in a child process. Throws InputError, or Failure if
/// the process cannot be started.
Directivity read_sofa_directivity(const std::filesystem::path& file);

}  // namespace aula
