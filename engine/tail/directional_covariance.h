#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/direction_moments.h"

namespace aula {

/// Covariance of the channels of an ambisonic field (ACN, SN3D) whose directions of arrival have
/// given moments, as a mixing matrix of independent noises. Immutable. [propagation thread]
class DirectionalCovariance {
 public:
    explicit DirectionalCovariance(int order);

    std::size_t channels() const { return channels_; }
    /// Number of elements of a lower triangular matrix, stored row by row.
    std::size_t triangle() const { return channels_ * (channels_ + 1) / 2; }

    /// The lower triangular matrix L such that L n has the covariance of the field per unit energy,
    /// for independent noises n of unit variance, one per channel. The first channel (W) is n[0].
    /// `directions` are those of unit energy.
    void mixing(const DirectionMoments& directions, float* triangle) const;

 private:
    struct Term {
        std::uint32_t harmonic;
        double factor;
    };

    void set_high_degrees(const DirectionMoments& directions, double* harmonics) const;

    int order_;
    std::size_t channels_;
    std::vector<std::vector<Term>> products_;  ///< [pair of channels, as in a triangle]
    /// [harmonic of degree 3 or 5][axis y, z, x] The product of both.
    std::vector<std::vector<Term>> along_axes_;
};

}  // namespace aula
