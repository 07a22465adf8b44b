#include "engine/estimate/pair_response.h"

#include <algorithm>
#include <utility>

namespace aula {

namespace {

/// Beyond this movement of ends and scene together in a frame, a response has nothing to do with
/// the one before: it is that of another row of seats, or behind a corner. Walks are 20 times
/// slower.
constexpr double kJump_m = 1;

}  // namespace

void PairResponse::begin_frame(double moved_m) {
    moved_m_ = moved_m;
    if (moved_m <= kJump_m) return;
    follower_.restart();
    detected_follower_.restart();
}

void PairResponse::end_gather(std::uint64_t rays) {
    if (moved_m_ > 0 || weight_ == 0) {
        frames_ = 1;
        weight_ = static_cast<double>(rays);
        std::swap(mean_, gathered_);
        follower_.follow(mean_, 1, moved_m_);
        return;
    }
    ++frames_;
    weight_ += static_cast<double>(rays);
    const auto part = static_cast<float>(static_cast<double>(rays) / weight_);
    approach(gathered_, 0, mean_.bins.count(), part, mean_);
    follower_.follow(mean_, frames_, 0);
}

void PairResponse::detect(const RayScene& scene, const SegmentCache& of_source,
                          const Receiver& at_listener, const SegmentCache& of_listener,
                          const Receiver& at_source, const OrientedDirectivity& directivity) {
    const bool continues = moved_m_ == 0 && segments_current_ && !detected_.full();
    segments_current_ = of_source.is_current() && of_listener.is_current();
    if (!continues) detected_.clear();
    const std::uint64_t rays = std::max(detected_.rays(), of_source.rays() + of_listener.rays());
    of_source.add_to(scene, at_listener, {}, continues, rays, detected_);
    of_listener.add_to(scene, at_source, directivity, continues, rays, detected_);
    detected_frames_ = continues ? detected_frames_ + 1 : 1;
    detected_mean_.clear_bins();
    detected_.add_others_to(detected_mean_);
    detected_follower_.follow(detected_mean_, detected_frames_, moved_m_);
}

void PairResponse::add_detected_to(const SpecularSound& images, EnergyResponse& response) const {
    // An image source replaces its detections at once.
    detected_.add_images_to(images, response);
    const EnergyResponse& others = detected_follower_.response();
    for (std::size_t k = 0; k < others.bins.count(); ++k) {
        response.energy[k] += others.energy[k];
        response.directions[k] += others.directions[k];
    }
}

}  // namespace aula
