#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "aula/engine/scene.h"

namespace aula {

/// Covariance of the channels of an ambisonic field (ACN, SN3D) whose directions of arrival have a
/// given mean, as a mixing matrix of independent noises. Immutable. [propagation thread]
class DirectionalCovariance {
 public:
    explicit DirectionalCovariance(int order);

    std::size_t channels() const { return channels_; }
    /// Number of elements of a lower triangular matrix, stored row by row.
    std::size_t triangle() const { return channels_ * (channels_ + 1) / 2; }

    /// The lower triangular matrix L such that L n has the covariance of the field per unit energy,
    /// for independent noises n of unit variance, one per channel. The first channel (W) is n[0].
    /// `mean` is the energy-weighted mean of the unit directions: of length 1 for one direction, 0
    /// for a diffuse field.
    void mixing(const Vec3& mean, float* triangle) const;

 private:
    struct Term {
        std::uint32_t harmonic;
        double factor;
    };

    int order_;
    std::size_t channels_;
    std::vector<std::vector<Term>> products_;   ///< [pair of channels, as in a triangle]
    std::vector<std::vector<double>> moments_;  ///< [length of the mean][order of harmonic]
};

}  // namespace aula
