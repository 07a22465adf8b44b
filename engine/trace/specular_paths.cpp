#include "engine/trace/specular_paths.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>
#include <utility>

#include "engine/base/sampling.h"
#include "engine/rays/plane_sequence.h"

namespace aula {
namespace {

using Point = ScenePlanes::Point;

constexpr std::size_t kMostListed = 4096;
constexpr std::size_t kMostDiscovered = 4096;
constexpr std::uint32_t kChains = 512;
constexpr double kNearest_m = 0.1;

// The reflection points are constructed for a source this far beside the real one: in symmetric
// rooms paths meet edges exactly, where both orders of the two planes would count, or neither.
constexpr Point kNudge_m(1.1e-4, 1.9e-4, 3.7e-4);
// A nudge does not cross a plane that is farther away; off_surface moves places farther, too.
constexpr double kOnPlane_m = 5e-4;

// A ray from this far above a reflection point looks for the face below. Merged triangles lie up
// to 1 mm beside their plane.
constexpr double kProbe_m = 2e-3;

// exp(-attenuation d) / (4 pi d^2), the length of a path as it is, its spreading without the
// singularity.
Bands spread_over(double length_m, const Bands& attenuation_per_m) {
    const double d = std::max(length_m, kNearest_m);
    Bands energy;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        energy[b] = static_cast<float>(std::exp(-double{attenuation_per_m[b]} * length_m) /
                                       (4 * std::numbers::pi * d * d));
    }
    return energy;
}

double largest(const Point& p) { return std::max({p.x, p.y, p.z}); }

Bands mirrored_share(const Material& material) {
    return complement(material.absorption) * complement(material.scattering);
}

Vec3 unit_or_front(const Point& p) {
    const double length = glm::length(p);
    return length > 0 ? Vec3(p / length) : Vec3(1, 0, 0);
}

}  // namespace

/// What path_along() needs for each plane of a sequence.
struct SpecularPaths::Workspace {
    /// Set if rays along the sequence may cross the sphere of a listener or source: if the path is
    /// valid or its reflection points lie beside the bounds of their planes by no more than what
    /// the sphere covers there.
    bool near = false;
    std::vector<Point> images;
    std::vector<Ray> probes;
    std::vector<Hit> hits;
};

SpecularPaths::SpecularPaths(const RayScene& scene, int order, float radius_m, std::uint64_t seed)
    : scene_(scene),
      order_(static_cast<std::size_t>(order)),
      radius_m_(double{radius_m}),
      seed_(seed),
      planes_(scene) {
    assert(order >= 0);
    list_sequences();
}

void SpecularPaths::restart(std::uint64_t seed) {
    seed_ = seed;
    discovered_.clear();
    frame_ = 0;
}

void SpecularPaths::scene_moved() {
    const std::size_t before = planes_.count();
    planes_.scene_moved();
    if (planes_.count() != before) list_sequences();
}

/// All sequences, order by order, as long as they are few.
void SpecularPaths::list_sequences() {
    std::vector<std::uint32_t> mirrors;
    for (std::uint32_t p = 0; p < planes_.count(); ++p) {
        if (planes_[p].reflects) mirrors.push_back(p);
    }
    listed_.clear();
    listed_order_ = 0;
    std::size_t begin = 0;  // of the sequences of the order before
    while (listed_order_ < order_) {
        const std::size_t end = listed_.size();
        const std::size_t more = listed_order_ == 0 ? mirrors.size()
                                 : mirrors.empty()  ? 0
                                                    : (end - begin) * (mirrors.size() - 1);
        if (end + more > kMostListed) return;
        for (const std::uint32_t last : mirrors) {
            if (listed_order_ == 0) listed_.push_back({last});
            for (std::size_t i = begin; i < end; ++i) {
                if (listed_[i].back() == last) continue;
                Sequence longer = listed_[i];
                longer.push_back(last);
                listed_.push_back(std::move(longer));
            }
        }
        begin = end;
        ++listed_order_;
    }
}

void SpecularPaths::discover(const Vec3& listener, std::uint64_t frame) {
    frame_ = frame;
    if (listed_order_ == order_) return;
    const ScrambledSobol sobol(derive_seed(seed_, frame));
    std::vector<Ray> rays(kChains);
    std::vector<Sequence> chains(kChains);
    std::vector<PlaneSequence> keys(kChains);
    RandomStream random(derive_seed(seed_, frame, 1));
    for (std::uint32_t i = 0; i < kChains; ++i) {
        // From all of the sphere: from its middle, sequences that are valid there would be met
        // first, and those beside them be left to the rays as well.
        const auto radius_m = static_cast<float>(radius_m_) * std::cbrt(random.uniform());
        const Vec3 place = listener + radius_m * uniform_direction(random.uniform_2d());
        rays[i] = {.origin = scene_.visible(listener, place) ? place : listener,
                   .direction = uniform_direction(sobol.point(i))};
    }
    std::vector<Hit> hits;
    for (std::size_t bounce = 1; bounce <= order_ && !rays.empty(); ++bounce) {
        hits.resize(rays.size());
        scene_.intersect(rays, hits);
        std::size_t alive = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].any()) continue;
            const std::uint32_t plane = planes_.of_triangle(hits[i].triangle);
            const Material& material = scene_.material(scene_.triangle(hits[i].triangle));
            if (plane == ScenePlanes::kNoPlane || mirrored_share(material).max() <= 0) continue;
            if (!chains[i].empty() && chains[i].back() == plane) continue;
            chains[i].push_back(plane);
            keys[i] = keys[i].then_from_listener(plane);
            if (bounce > listed_order_) {
                discovered_.try_emplace(keys[i].key, chains[i], frame_);
            }
            const Vec3 direction = rays[i].direction;
            rays[alive] = {
                .origin = scene_.point(hits[i], direction),
                .direction = mirror(direction, scene_.facing_normal(hits[i], direction))};
            std::swap(chains[alive], chains[i]);
            std::swap(keys[alive], keys[i]);
            ++alive;
        }
        rays.resize(alive);
        chains.resize(alive);
    }
    evict();
}

/// Keeps the candidates that are new or near to a path, then those that were most recently; of
/// equal ones the lowest orders and the smallest keys, which have nothing to do with where source
/// and listener are.
void SpecularPaths::evict() {
    if (discovered_.size() <= kMostDiscovered) return;
    std::vector<std::tuple<std::uint64_t, std::size_t, std::uint64_t>> ranks;  // age, order, key
    ranks.reserve(discovered_.size());
    for (const auto& [key, candidate] : discovered_) {
        const std::uint64_t last_frame = candidate.last_frame.load(std::memory_order_relaxed);
        ranks.emplace_back(frame_ - std::min(last_frame, frame_), candidate.sequence.size(), key);
    }
    const auto kept = ranks.begin() + kMostDiscovered;
    std::nth_element(ranks.begin(), kept, ranks.end());
    for (auto i = kept; i != ranks.end(); ++i) discovered_.erase(std::get<2>(*i));
}

std::vector<SpecularPath> SpecularPaths::find(const Vec3& source, const Vec3& listener, bool direct,
                                              const Bands& attenuation_per_m) const {
    std::vector<SpecularPath> paths;
    Workspace work;
    if (direct && scene_.visible(listener, source)) {
        const Point offset = Point(source) - Point(listener);
        const double length_m = glm::length(offset);
        paths.push_back({.order = 0,
                         .length_m = static_cast<float>(length_m),
                         .direction = unit_or_front(offset),
                         .energy = spread_over(length_m, attenuation_per_m),
                         .id = 0});
    }
    for (const Sequence& sequence : listed_) {
        if (auto path = path_along(sequence, source, listener, attenuation_per_m, work)) {
            paths.push_back(*path);
        }
    }
    for (const auto& [key, candidate] : discovered_) {
        work.near = false;
        if (auto path = path_along(candidate.sequence, source, listener, attenuation_per_m, work)) {
            paths.push_back(*path);
        }
        if (work.near) candidate.last_frame.store(frame_ + 1, std::memory_order_relaxed);
    }
    std::sort(paths.begin(), paths.end(), [](const SpecularPath& a, const SpecularPath& b) {
        return std::tie(a.length_m, a.order, a.id) < std::tie(b.length_m, b.order, b.id);
    });
    return paths;
}

// The images of the source, mirrored from the last plane to the first, give the reflection points
// from the listener on: the segment to each points at the image through the planes that remain.
std::optional<SpecularPath> SpecularPaths::path_along(const Sequence& sequence, const Vec3& source,
                                                      const Vec3& listener,
                                                      const Bands& attenuation_per_m,
                                                      Workspace& work) const {
    if (std::abs(planes_[sequence.back()].distance_m(Point(source))) < kOnPlane_m ||
        std::abs(planes_[sequence.front()].distance_m(Point(listener))) < kOnPlane_m) {
        return std::nullopt;
    }
    Point image(source);
    work.images.resize(sequence.size());
    Point nudged = image + kNudge_m;
    for (std::size_t k = sequence.size(); k-- > 0;) {
        image = planes_[sequence[k]].mirror(image);
        work.images[k] = nudged = planes_[sequence[k]].mirror(nudged);
    }

    // Where the segments cross the planes, without casting a ray.
    work.probes.resize(sequence.size());
    Point from(listener);
    bool inside = true;
    for (std::size_t k = 0; k < sequence.size(); ++k) {
        const ScenePlanes::Plane& plane = planes_[sequence[k]];
        const double here_m = plane.distance_m(from);
        const double image_m = plane.distance_m(work.images[k]);
        if (!(here_m * image_m < 0)) return std::nullopt;
        const Point at = from + (work.images[k] - from) * (here_m / (here_m - image_m));
        const double outside_m =
            std::max(largest(Point(plane.low) - at), largest(at - Point(plane.high)));
        if (outside_m > kProbe_m) {
            inside = false;
            // A sphere that moves a reflection point by R across the path moves it by R / cos.
            const double cosine = std::abs(here_m - image_m) / glm::distance(from, work.images[k]);
            if (outside_m * cosine > radius_m_) return std::nullopt;
        }
        const Point outward = here_m > 0 ? plane.normal : -plane.normal;
        work.probes[k] = {.origin = Vec3(at + kProbe_m * outward),
                          .direction = Vec3(-outward),
                          .max_m = static_cast<float>(2 * kProbe_m)};
        from = at;
    }
    work.near = true;
    if (!inside) return std::nullopt;

    // A face of the plane must be there, on the side of the segment.
    work.hits.resize(sequence.size());
    scene_.intersect(work.probes, work.hits);
    Bands energy = Bands::filled(1);
    for (std::size_t k = 0; k < sequence.size(); ++k) {
        if (!work.hits[k].any() || planes_.of_triangle(work.hits[k].triangle) != sequence[k]) {
            return std::nullopt;
        }
        energy *= mirrored_share(scene_.material(scene_.triangle(work.hits[k].triangle)));
    }
    if (energy.max() <= 0) return std::nullopt;

    // No segment may be obstructed.
    Vec3 start = listener;
    for (std::size_t k = 0; k < sequence.size(); ++k) {
        const Vec3 end = scene_.point(work.hits[k], work.probes[k].direction);
        if (!scene_.visible(start, end)) return std::nullopt;
        start = end;
    }
    if (!scene_.visible(start, source)) return std::nullopt;

    const Point offset = image - Point(listener);
    const double length_m = glm::length(offset);
    PlaneSequence planes;
    for (const std::uint32_t plane : sequence) planes = planes.then_from_listener(plane);
    return SpecularPath{.order = static_cast<int>(sequence.size()),
                        .length_m = static_cast<float>(length_m),
                        .direction = unit_or_front(offset),
                        .energy = energy * spread_over(length_m, attenuation_per_m),
                        .id = planes.key};
}

}  // namespace aula
