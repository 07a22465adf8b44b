#include "engine/patches/sound_reach.h"

#include <algorithm>

#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

/// Beside the numbers of triangles, which select the samples of a SurfaceSampler of the same seed.
enum class ReachSeed : std::uint64_t { samples = 1 << 29, walks = 1 << 30 };

/// Attempts to reach the sound from a sample. A choice: one that sees marked patches in half of
/// its directions fails with a probability of 6 %.
constexpr int kReachAttempts = 4;

/// Samples of a job. A choice: some thousand rays.
constexpr std::size_t kChunk = 1024;

/// Walks of a round, their segments, and rounds at most. A choice: 131,072 rays of a round, and 1.6
/// million of all. Half and twice of each change noise and energy by less than 1 %
/// (`aula-bench noise --estimator patch --rays 1000 scenes/museum.json`).
constexpr int kWalks = 4096;
constexpr int kWalkBounces = 32;  // as many as of a survey of a room
constexpr int kWalkRounds = 12;

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

bool SoundReach::mark(std::span<const Vec3> inside, double max_patches, IrradianceMap& irradiance) {
    std::size_t hits = 0;
    for (int round = 0; round < kWalkRounds; ++round) {
        const std::size_t before = count_;
        const RandomWalks walks{.paths = kWalks,
                                .bounces = kWalkBounces,
                                .seed = derive_seed(seed_, ReachSeed::walks, round),
                                .through_walls = true,
                                .leave_m = kLeave_patches * grid_.size_m()};
        trace_random_walks(scene_, inside, walks,
                           [&](int reflections, const Ray& ray, const Hit& hit) {
                               if (!hit.any() || scene_.moves(scene_.triangle(hit.triangle)))
                                   return;
                               const Vec3 point = scene_.point(hit, ray.direction);
                               const Vec3 normal = scene_.facing_normal(hit, ray.direction);
                               const std::uint32_t patch = index_.find(grid_.key_at(point, normal));
                               if (patch == PatchIndex::kNone) return;
                               // Direct sound is omitted, as are reflections in the corner of
                               // which a walk begins: their distribution depends on the start.
                               if (reflections > 0) {
                                   irradiance.add_hit(patch, hit.triangle, point, normal);
                                   ++hits;
                               }
                               mark(patch);
                           });
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
             derive_seed(seed_, ReachSeed::samples, chunk));
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
