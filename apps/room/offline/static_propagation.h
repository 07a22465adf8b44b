#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "apps/room/images/box_images.h"
#include "aula/engine/energy_response.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene.h"

namespace aula {

/// Propagation from the sources of a scene to receivers with everything at rest, window by window.
/// A window is a number of consecutive frames from empty caches. With Estimator::patch the first
/// receiver is heard as a listener of a live scene, with a gather in each frame. The other
/// receivers gather once in several frames, so that hundreds of them cost little and need no state.
/// An empty box that scatters nothing has its images instead, and no rays.
/// [one thread]
class StaticPropagation {
 public:
    /// The frames from one gather of further receivers to the next, by their number.
    static int gather_frames(std::size_t further_receivers);

    /// Sources and objects are at their positions at time 0. The scene outlives the object.
    StaticPropagation(const Scene& scene, std::span<const Pose> receivers);

    /// The combined result of the next `count` frames from empty caches, [pair]; empty if
    /// `continues`, called with the number of all frames, returns false after a frame.
    std::vector<EnergyResponse> window(int count, const std::function<bool(int)>& continues);

    int frames() const { return frames_; }
    /// Computation time of all frames as counted from their work, in s; see counted_s().
    double work_s() const { return work_s_; }
    double response_length_s() const { return response_length_s_; }
    float patch_size_m() const { return propagation_ ? propagation_->patch_size_m() : 0; }
    /// All images of the scene, which make every window exact; null for rays.
    std::shared_ptr<const BoxImages> images() const { return images_; }

    /// [pair] 1 if sound can reach the receiver. Requires a frame.
    std::vector<char> connected() const;

 private:
    bool gathers_at(int frame, int count) const;
    std::vector<EnergyResponse> image_responses(std::size_t sources) const;

    const Simulation& simulation_;
    std::vector<Vec3> receivers_;
    std::size_t listeners_;  ///< the first receivers are listeners, whose responses each step
                             ///< computes; the others gather from the sources' caches
    std::shared_ptr<const BoxImages> images_;
    std::optional<Propagation> propagation_;  ///< not with images
    double response_length_s_ = 0;
    FrameInput input_;
    std::uint64_t windows_ = 0;
    int frames_ = 0;
    double work_s_ = 0;
};

}  // namespace aula
