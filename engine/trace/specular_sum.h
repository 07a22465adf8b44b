#pragma once

#include <cstdint>
#include <map>

#include "aula/engine/energy_response.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// The sum of what one listener detected on the segments of one source's rays since source,
/// listener or scene last changed. Paths that an image source may count are summed separately per
/// image, and contribute while that image is not tried. [propagation thread]
class SpecularSum {
 public:
    explicit SpecularSum(const EnergyResponse& silent) : sum_(silent) {}

    /// Removes all contributions.
    void clear();

    /// Adds emitted rays, then their detections.
    void add_rays(std::uint64_t rays) { rays_ += rays; }
    void add(const SegmentEnergy& sound, const Bands& energy, float length_m);

    /// Adds the mean over all rays to a response.
    void add_to(const SpecularSound& images, EnergyResponse& response) const {
        add_others_to(response);
        add_images_to(images, response);
    }

    /// The part of the paths that an image source may count.
    void add_images_to(const SpecularSound& images, EnergyResponse& response) const;

    /// The part of all other paths.
    void add_others_to(EnergyResponse& response) const;

    std::uint64_t rays() const { return rays_; }

    /// True if the limit of images is reached: clear() and restart with the newest rays.
    bool full() const { return by_image_.size() >= kMaxImages; }

 private:
    /// A choice: 2 MB for each pair.
    static constexpr std::size_t kMaxImages = 1 << 14;

    struct Detected {
        Bands energy;
        DirectionMoments directions;
        double length_m = 0;
        double count = 0;
    };

    EnergyResponse sum_;  ///< of the paths that no image source counts
    std::map<std::uint64_t, Detected> by_image_;
    std::uint64_t rays_ = 0;
};

}  // namespace aula
