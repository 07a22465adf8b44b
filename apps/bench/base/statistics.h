#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"

namespace aula::bench {

/// Width of the bins of all figures, and the number of bins in a group.
inline constexpr double kBin_s = 0.01;
inline constexpr std::size_t kGroupBins = 5;

/// A range of bins [first, end).
struct BinRange {
    std::size_t first = 0;
    std::size_t end = 0;

    std::size_t count() const { return end - first; }
};

/// The bins from 50 to 500 ms, of `bin_count` at most.
BinRange late_bins(std::size_t bin_count);

/// The same from the first group on in which no bin of the reference is more than 30 dB below the
/// strongest late one: before that, a response has hardly begun.
BinRange audible_bins(std::span<const double> reference);

/// Reflected sound: bins and image sources, without the direct sound. A specular path is in either,
/// depending on whether its image source has been discovered. Energy per whole bin of kBin_s,
/// summed over the octave bands, up to 500 ms, in 1/m2.
std::vector<double> estimated_energy(const EnergyResponse& response);

/// The same for the direction sums, per group of bins.
std::vector<Vec3> estimated_direction(const EnergyResponse& response);

/// Relative standard deviation over the restarts, averaged over bins: `restarts[i][bin]`, at least
/// two. Bins that are empty in all restarts are excluded.
double relative_deviation(const std::vector<std::vector<double>>& restarts, BinRange bins);

/// Standard deviation of the direction about its mean over the restarts, in degrees, averaged over
/// the groups of `bins`: `restarts[i][group]`, at least two.
double direction_deviation_deg(const std::vector<std::vector<Vec3>>& restarts, BinRange bins);

/// Energy over that of the reference in groups of bins, averaged over restarts and groups.
double energy_ratio(const std::vector<std::vector<double>>& restarts,
                    std::span<const double> reference, BinRange bins);

/// From the bin of the reference's peak to the end.
BinRange bins_from_peak(std::span<const double> reference);

/// Sum over `bins` of the squared relative error.
double squared_relative_error(std::span<const double> energy, std::span<const double> reference,
                              BinRange bins);

/// The mean of independent values.
double mean(std::span<const double> values);

/// The upper median of values, at least one.
double median(std::vector<double> values);

/// Standard error of their mean; 0 for one value.
double standard_error(std::span<const double> values);

/// Rms error without that of the reference, which is subtracted in squares; 0 below the
/// reference's.
double without_reference_error(double error, double reference_error);

}  // namespace aula::bench
