#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "aula/engine/directivity.h"

namespace aula {

/// Draws the directions of rays from a source with a density that follows the mean of its
/// directivity over all bands. The sphere is divided into cells of equal area; the density is
/// constant in each.
class EmissionSampler {
 public:
    /// The directivity is not omnidirectional.
    explicit EmissionSampler(const Directivity& directivity);

    const Directivity& directivity() const { return directivity_; }

    /// Maps uniform numbers to a direction in the local axes of the source and the energy of its
    /// ray, the factor of the directivity over the density. In each band the mean energy of all
    /// rays is 1.
    std::pair<Vec3, Bands> sample(const std::array<float, 2>& u) const;

 private:
    Directivity directivity_;
    std::vector<float> row_ends_;                  ///< [row] cumulative probability, from 0 to 1
    std::vector<std::vector<float>> column_ends_;  ///< [row][column] the same within a row
};

/// The directivity of a source with its orientation in a frame.
class OrientedDirectivity {
 public:
    /// Omnidirectional.
    OrientedDirectivity() = default;

    /// `rotation`: from the local axes of the source to the world axes.
    OrientedDirectivity(std::shared_ptr<const EmissionSampler> sampler, const glm::mat3& rotation)
        : sampler_(std::move(sampler)), rotation_(rotation) {}

    bool is_omnidirectional() const { return sampler_ == nullptr; }

    /// Directivity::factor of a direction in world axes.
    Bands factor(const Vec3& direction) const {
        return is_omnidirectional() ? Bands::filled(1)
                                    : sampler_->directivity().factor(direction * rotation_);
    }

    /// A direction in world axes for uniform numbers, and the energy of its ray: 1 for an
    /// omnidirectional source.
    std::pair<Vec3, Bands> sample(const std::array<float, 2>& u) const;

    /// The movement that a turn counts as for the caches: 1 m times the mean change of the factor
    /// over bands and directions. 0 only if the orientations are equal.
    double turned_m(const OrientedDirectivity& before) const;

    /// The same directivity in the same orientation.
    friend bool operator==(const OrientedDirectivity&, const OrientedDirectivity&) = default;

 private:
    std::shared_ptr<const EmissionSampler> sampler_;  ///< null: omnidirectional
    glm::mat3 rotation_{1};
};

}  // namespace aula
