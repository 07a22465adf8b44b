#include "engine/cache/segment_cache.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "engine/base/air_attenuation.h"
#include "engine/base/sampling.h"
#include "engine/trace/detection_spheres.h"
#include "process/multiversion.h"

namespace aula {

namespace {

enum class SeedPurpose : std::uint64_t { part = 1 };

/// Finds the segments on straight lines that cross a receiver's sphere; most of them are detected.
AULA_MULTIVERSION
void find_near(const std::vector<SegmentLanes>& segments, const Receiver& receiver,
               float wave_front_1_m2, std::vector<std::uint32_t>& near) {
    const Vec3 centre = receiver.position;
    const float radius_2 = receiver.radius_m * receiver.radius_m;
    for (std::size_t block = 0; block < segments.size(); ++block) {
        const auto& [ox, oy, oz] = segments[block].origin;
        const auto& [dx, dy, dz] = segments[block].direction;
        const SegmentLanes::Lanes& before_m = segments[block].before_m;
        const SegmentLanes::Lanes& growth = segments[block].growth;
        std::array<std::int32_t, SegmentLanes::kCount> crosses;
        std::int32_t any = 0;
        for (std::size_t i = 0; i < SegmentLanes::kCount; ++i) {
            const float x = centre.x - ox[i];
            const float y = centre.y - oy[i];
            const float z = centre.z - oz[i];
            const float along = x * dx[i] + y * dy[i] + z * dz[i];
            const float sphere_2 =
                radius_2 * sphere_growth(growth[i], before_m[i], wave_front_1_m2);
            crosses[i] = x * x + y * y + z * z - along * along < sphere_2 ? 1 : 0;
            any |= crosses[i];
        }
        if (any == 0) continue;
        for (std::size_t i = 0; i < SegmentLanes::kCount; ++i) {
            if (crosses[i] != 0) {
                near.push_back(static_cast<std::uint32_t>(block * SegmentLanes::kCount + i));
            }
        }
    }
}

}  // namespace

void SegmentLanes::set(std::size_t lane, const PathSegment& segment) {
    for (int axis = 0; axis < 3; ++axis) {
        origin[static_cast<std::size_t>(axis)][lane] = segment.origin[axis];
        direction[static_cast<std::size_t>(axis)][lane] = segment.direction[axis];
    }
    length_m[lane] = segment.length_m;
    before_m[lane] = segment.before_m;
    growth[lane] = segment.growth;
}

PathSegment SegmentLanes::at(std::size_t lane) const {
    return {Vec3(origin[0][lane], origin[1][lane], origin[2][lane]),
            Vec3(direction[0][lane], direction[1][lane], direction[2][lane]), length_m[lane],
            before_m[lane], growth[lane]};
}

double SegmentCache::State::moved_m(const State& older) const {
    return double{glm::distance(emitter, older.emitter)} + travel_m - older.travel_m;
}

void SegmentCache::advance(const State& now) {
    if (now.changed_since(now_)) evicted_ = false;
    now_ = now;
    while (!frames_.empty() && !holds(frames_.front())) forget_oldest();
}

/// The number of segments that fit in a memory.
std::size_t SegmentCache::fit(std::size_t memory_bytes) {
    // Of full lanes.
    constexpr std::size_t kBlock_bytes =
        sizeof(SegmentLanes) + SegmentLanes::kCount * sizeof(SegmentEnergy);
    const std::size_t rest_bytes = memory_bytes % kBlock_bytes;
    const std::size_t in_rest = std::max(rest_bytes, sizeof(SegmentLanes)) - sizeof(SegmentLanes);
    return memory_bytes / kBlock_bytes * SegmentLanes::kCount + in_rest / sizeof(SegmentEnergy);
}

bool SegmentCache::holds(const Frame& frame) const {
    const double moved_m = now_.moved_m(frame.state);
    return moved_m == 0 ||
           (moved_m <= double{reach_m_} && now_.frame - frame.state.frame < window_frames_);
}

void SegmentCache::forget_oldest() {
    segment_count_ -= frames_.front().sounds.size();
    bytes_ -= frames_.front().memory_bytes();
    rays_ -= frames_.front().rays;
    spare_ = std::move(frames_.front());
    frames_.pop_front();
}

void SegmentCache::add(std::span<const DepositBatch> batches, int rays) {
    auto rays_kept = static_cast<std::uint64_t>(rays);
    std::size_t count = 0;
    for (const DepositBatch& batch : batches) count += batch.segments.size();
    // Of a frame that alone exceeds the memory, a part represents all: that of fewer rays.
    const std::size_t fit = SegmentCache::fit(memory_bytes_);
    if (count > fit) {
        rays_kept = std::max<std::uint64_t>(1, rays_kept * fit / count);
    }
    // Stratified sampling: one segment at random of each 1 / part; their number is certain to one.
    // At equal steps segments would follow the structure of the rays' low-discrepancy directions.
    const double part = static_cast<double>(rays_kept) / rays;
    count = static_cast<std::size_t>(std::ceil(part * static_cast<double>(count)));
    while (!frames_.empty() &&
           ((segment_count_ + count > max_segments_ && frames_.size() >= window_frames_) ||
            bytes_ + Frame::memory_bytes(count) > memory_bytes_)) {
        forget_oldest();
        evicted_ = true;
    }
    if (spare_.sounds.capacity() > 2 * count) spare_ = {};
    Frame frame{now_, rays_kept, std::move(spare_.segments), std::move(spare_.sounds)};
    frame.segments.clear();
    frame.sounds.clear();
    frame.segments.reserve((count + SegmentLanes::kCount - 1) / SegmentLanes::kCount);
    frame.sounds.reserve(count);
    RandomStream random(derive_seed(now_.frame, SeedPurpose::part));
    const auto next = [&] {
        if (part == 1) return frame.sounds.size();
        const double stratum = static_cast<double>(frame.sounds.size());
        return static_cast<std::size_t>((stratum + double{random.uniform()}) / part);
    };
    std::size_t index = 0;
    std::size_t chosen = next();
    for (const DepositBatch& batch : batches) {
        for (std::size_t i = 0; i < batch.segments.size(); ++i, ++index) {
            for (; chosen == index; chosen = next()) {
                const std::size_t lane = frame.sounds.size() % SegmentLanes::kCount;
                if (lane == 0) frame.segments.emplace_back();
                frame.segments.back().set(lane, batch.segments[i]);
                frame.sounds.push_back(batch.segment_energies[i]);
            }
        }
    }
    segment_count_ += frame.sounds.size();
    bytes_ += frame.memory_bytes();
    rays_ += frame.rays;
    frames_.push_back(std::move(frame));
}

bool SegmentCache::is_current() const {
    return frames_.empty() || now_.moved_m(frames_.front().state) == 0;
}

void SegmentCache::add_to(const RayScene& scene, const Receiver& receiver,
                          const OrientedDirectivity& directivity, bool only_present,
                          std::uint64_t rays, SpecularSum& sum) const {
    const float wave_front_1_m2 =
        wave_front_growth_1_m2(static_cast<double>(rays), receiver.radius_m);
    std::vector<std::uint32_t> near;
    for (const Frame& frame : frames_) {
        if (only_present && frame.state.frame != now_.frame) continue;
        sum.add_rays(frame.rays);
        near.clear();
        near.reserve(frame.segments.size() * SegmentLanes::kCount);
        best_version<find_near>(frame.segments, receiver, wave_front_1_m2, near);
        for (const std::uint32_t i : near) {
            const PathSegment segment =
                frame.segments[i / SegmentLanes::kCount].at(i % SegmentLanes::kCount);
            const float growth = sphere_growth(segment.growth, segment.before_m, wave_front_1_m2);
            const auto chord = receiver.chord(scene, segment.origin, segment.direction,
                                              segment.length_m, Receiver::sphere_of(growth));
            if (!chord) continue;
            const SegmentEnergy& sound = frame.sounds[i];
            Bands energy =
                sound.energy * transmission(attenuation_per_m_, chord->at_m) * chord->share_1_m2;
            // Sound leaves the source against the direction of a listener's ray.
            if (!directivity.is_omnidirectional()) energy *= directivity.factor(-segment.direction);
            sum.add(sound, energy, segment.before_m + chord->at_m);
        }
    }
}

}  // namespace aula
