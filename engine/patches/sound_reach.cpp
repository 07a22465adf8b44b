#include "engine/patches/sound_reach.h"

#include <algorithm>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"

namespace aula {

namespace {

/// Beside the numbers of triangles, which select the samples of a SurfaceSampler of the same seed.
constexpr std::uint64_t kSampleSeed = 1 << 29;

/// Attempts to reach the sound from a sample. A choice: one that sees marked patches in half of
/// its directions fails with a probability of 6 %.
constexpr int kReachAttempts = 4;

/// Samples of a job. A choice: some thousand rays.
constexpr std::size_t kChunk = 1024;

/// Another round follows one that marks a patch for each of as many that are marked.
constexpr std::size_t kMarkedPerNew = 100;

/// Distance from the start from which on hits count: a walk that begins in a corner stays there for
/// some reflections, whose hits would raise the irradiance of the corner. A choice: beyond, a
/// corner fills a small part of what a surface sees.
constexpr float kLeave_patches = 2;

/// Mean number of hits of a patch that estimates the irradiance of its parts: of one with a tenth
/// of them the standard error is 14 %.
constexpr std::size_t kHitsPerPatch = 512;

}  // namespace

void SoundReach::mark(std::uint32_t patch) {
    if (patch >= marked_.size()) marked_.resize(index_.size(), 0);
    if (marked_[patch]) return;
    marked_[patch] = 1;
    ++count_;
}

bool SoundReach::mark(ReachWalks& walks, double max_patches, IrradianceMap& irradiance) {
    const float leave_m = kLeave_patches * grid_.size_m();
    std::size_t hits = 0;
    for (int round = 0; round < ReachWalks::kRounds; ++round) {
        const std::size_t before = count_;
        for (const ReachWalks::End& end : walks.round(round)) {
            const Vec3 normal = walks.normal(end);
            const std::uint32_t patch = index_.find(grid_.key_at(end.point, normal));
            if (patch == PatchIndex::kNone) continue;
            // Direct sound is omitted, as are reflections in the corner of which a walk begins:
            // their distribution depends on the start.
            if (end.farthest_m >= leave_m) {
                irradiance.add_hit(patch, end.triangle, end.point, normal);
                ++hits;
            }
            mark(patch);
        }
        if (static_cast<double>(count_) > max_patches) return false;
        if (count_ - before <= count_ / kMarkedPerNew && hits >= kHitsPerPatch * count_) break;
    }
    return static_cast<double>(count_) <= max_patches;
}

std::vector<char> SoundReach::reaches(std::span<const SurfaceSample> samples,
                                      WorkerPool& workers) const {
    std::vector<char> reached(samples.size(), 0);
    workers.run((samples.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        const std::size_t first = chunk * kChunk;
        const std::size_t count = std::min(kChunk, samples.size() - first);
        test(samples.subspan(first, count), std::span(reached).subspan(first, count),
             derive_seed(seed_, kSampleSeed, chunk));
    });
    return reached;
}

void SoundReach::test(std::span<const SurfaceSample> samples, std::span<char> reached,
                      std::uint64_t seed) const {
    // Coincident faces count once: only the face that a ray hits.
    constexpr float kAbove_m = 2 * tolerances::kOffset_m;
    RandomStream random(seed);
    std::vector<Ray> rays(samples.size());
    std::vector<Hit> hits(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const Vec3& n = samples[i].normal;
        rays[i] = {samples[i].point + kAbove_m * n, -n, 2 * kAbove_m};
    }
    scene_.intersect(rays, hits);
    struct Attempt {
        std::size_t sample = 0;
        int left = kReachAttempts;
    };
    std::vector<Attempt> open;  // of samples that have not reached the sound yet
    for (std::size_t i = 0; i < samples.size(); ++i) {
        if (hits[i].triangle == samples[i].triangle) open.push_back({i});
    }
    const auto segment = [&](const Attempt& attempt) -> Ray {
        const SurfaceSample& sample = samples[attempt.sample];
        return {sample.nudged_off_surface(), lambert_direction(sample.normal, random.uniform_2d())};
    };
    follow_rays(scene_, open, segment, [&](Attempt& attempt, const Ray& ray, const Hit& hit) {
        if (has_sound(ray, hit)) reached[attempt.sample] = 1;
        return !reached[attempt.sample] && --attempt.left > 0;
    });
}

/// True if a ray ends where sound is: in the open, on a marked patch or on a moving object.
bool SoundReach::has_sound(const Ray& ray, const Hit& hit) const {
    if (!hit.any() || scene_.moves(scene_.triangle(hit.triangle))) return true;
    return marked(index_.find(
        grid_.key_at(scene_.point(hit, ray.direction), scene_.facing_normal(hit, ray.direction))));
}

}  // namespace aula
