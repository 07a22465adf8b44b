#include "engine/trace/specular_paths.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "engine/base/near_field.h"
#include "engine/base/sampling.h"
#include "engine/base/tolerances.h"
#include "engine/rays/follow_rays.h"

namespace aula {
namespace {

using Point = ScenePlanes::Point;

/// Sequences that are always candidates, and those that chains have met in addition. Choices: each
/// is mirrored for each pair in each frame. Those of six walls are listed up to order 4, those of
/// twenty up to order 2.
constexpr std::size_t kMaxListed = 4096;
constexpr std::size_t kMaxDiscovered = 4096;

/// Chains of a listener and frame. A choice: within tau each part of the sphere around the listener
/// with a thousandth of its area is met by eight at 30 frames per second.
constexpr std::uint32_t kChains = 512;

// Images of flutter of all sources at a listener, a choice: a hard box has 600 of a source, which
// take an eighth of the time of a rendering. Eight sources in it have those up to order 24.
constexpr std::size_t kMaxFlutter = 1024;

// Images are tested at this offset from their position: in symmetric rooms their paths meet edges
// and corners exactly, where a ray may miss the surfaces.
constexpr Point kNudge_m(1.1e-4, 1.9e-4, 3.7e-4);
// The nudge does not cross a plane beyond this distance; nudge_off_surface() moves points by more.
constexpr double kOnPlane_m = tolerances::kOnSurface_m;
static_assert(kNudge_m.x * kNudge_m.x + kNudge_m.y * kNudge_m.y + kNudge_m.z * kNudge_m.z <
              kOnPlane_m * kOnPlane_m);

// Merged triangles are up to kSame_m from their plane.
constexpr double kBesidePlane_m = tolerances::kApart_m;

// exp(-attenuation d) / (4 pi d^2). Attenuation uses the true path length; spreading is limited to
// kNearest_m, without the singularity.
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

/// The direction of a ray along `p`; any if it has no length.
Vec3 ray_direction(const Point& p) {
    const double length = glm::length(p);
    return length > 0 ? Vec3(p / length) : Vec3(1, 0, 0);
}

/// Calls work(part, parts) for each part, on all threads of a pool; one part without a pool.
template <typename Work>
void run_parts(WorkerPool* workers, const Work& work) {
    if (!workers) return work(0, 1);
    const auto parts = static_cast<std::size_t>(workers->threads());
    workers->run(parts, [&](std::size_t part) { work(part, parts); });
}

}  // namespace

struct SpecularPaths::Chain {
    Ray ray;  ///< of the next segment
    Sequence planes;
    ImageTransform transform;         ///< of all planes
    std::vector<std::uint64_t> keys;  ///< [k] of the first k + 1 planes
};

struct SpecularPaths::Probe {
    Probe(std::uint64_t image_key, std::size_t reflections, const Point& from, const Point& towards)
        : image(image_key),
          order(reflections),
          at(from),
          target(towards),
          origin(Vec3(from) + tolerances::kOffset_m * ray_direction(towards - from)) {}

    std::uint64_t image;
    std::size_t order;
    Point at;      ///< the last reflection point, or the listener before the first
    Point target;  ///< the image source as seen from `at`
    Vec3 origin;  ///< on the incoming ray, before `at`: no surface lies between it and the listener
    Sequence planes;
    Bands energy = Bands::filled(1);
};

SpecularPaths::SpecularPaths(const RayScene& scene, int order, float radius_m, std::uint64_t seed,
                             double flutter_m)
    : scene_(scene),
      order_(static_cast<std::size_t>(order)),
      radius_m_(double{radius_m}),
      seed_(seed),
      flutter_m_(flutter_m),
      planes_(scene) {
    assert(order >= 0);
    const Bounds bounds = scene.bounds();
    middle_ = scene.triangles().empty() ? Point(0) : 0.5 * (Point(bounds.min) + Point(bounds.max));
    add_mirrors();
    list_sequences();
    list_flutter();
}

void SpecularPaths::restart(std::uint64_t seed) {
    seed_ = seed;
    discovered_.clear();
    frame_ = 0;
}

void SpecularPaths::scene_moved() {
    const std::size_t before = planes_.count();
    planes_.scene_moved();
    if (planes_.count() == before) return;
    add_mirrors();
    list_sequences();
    list_flutter();
}

/// Extends mirrors_ to the number of planes. A plane that an object has left may have
/// become a facet.
void SpecularPaths::add_mirrors() {
    while (mirrors_.size() < planes_.count()) {
        const ScenePlanes::Plane& plane = planes_[static_cast<std::uint32_t>(mirrors_.size())];
        MirrorPlane mirror{plane.normal, plane.offset_m - glm::dot(plane.normal, middle_)};
        if (scene_.moves(scene_.triangle(plane.reference))) {
            RandomStream random(derive_seed(0x6d6f766564ULL, mirrors_.size()));
            mirror = {Point(uniform_direction(random.uniform_2d())), double{random.uniform()}};
            mirror.normal = glm::normalize(mirror.normal);
        }
        mirrors_.push_back(mirror);
        first_order_ids_.push_back(ImageTransform{}.then_from_listener(mirror).key());
    }
    for (std::uint32_t p = 0; p < planes_.count(); ++p)
        mirrors_[p].has_images = !planes_[p].is_facet();
}

void SpecularPaths::materials_changed() {
    planes_.materials_changed();
    list_sequences();
    list_flutter();
    discovered_.clear();
}

/// Lists all sequences, order by order, while their number is within the limit.
void SpecularPaths::list_sequences() {
    std::vector<std::uint32_t> mirrors;
    has_facets_ = false;
    for (std::uint32_t p = 0; p < planes_.count(); ++p) {
        if (!planes_[p].reflects) continue;
        if (planes_[p].is_facet()) {
            has_facets_ = true;
        } else {
            mirrors.push_back(p);
        }
    }
    const auto add = [&](Sequence sequence, std::uint32_t last) {
        sequence.push_back(last);
        const std::uint64_t image = key_of(sequence);
        listed_.push_back({std::move(sequence), image});
    };
    listed_.clear();
    listed_order_ = 0;
    std::size_t begin = 0;  // of the sequences of the previous order
    while (listed_order_ < order_) {
        const std::size_t end = listed_.size();
        const std::size_t more = listed_order_ == 0 ? mirrors.size()
                                 : mirrors.empty()  ? 0
                                                    : (end - begin) * (mirrors.size() - 1);
        if (end + more > kMaxListed) return;
        for (const std::uint32_t last : mirrors) {
            if (listed_order_ == 0) add({}, last);
            for (std::size_t i = begin; i < end; ++i) {
                if (listed_[i].sequence.back() != last) add(listed_[i].sequence, last);
            }
        }
        begin = end;
        ++listed_order_;
    }
}

/// Lists the sequences that alternate between the planes of a pair.
void SpecularPaths::list_flutter() {
    flutter_.clear();
    flutter_images_.clear();
    flutter_order_ = 0;
    if (flutter_m_ == 0 || order_ == 0) return;
    for (const FlutterPair& pair : flutter_pairs(scene_, planes_, flutter_m_)) {
        if (pair.order <= listed_order_) continue;
        Alternating alternating;
        for (std::size_t i = 0; i <= pair.order; ++i)
            alternating.sequence.push_back(pair.planes[i % 2]);
        for (auto& images : alternating.images) images.resize(pair.order);
        for (std::size_t i = 0; i < 2; ++i) {
            const Bounds& other = planes_[pair.planes[1 - i]].bounds;
            const Point middle = 0.5 * (Point(other.min) + Point(other.max));
            alternating.side[i] = planes_[pair.planes[i]].distance_m(middle) < 0 ? -1 : 1;
        }
        for (std::size_t first = 0; first < 2; ++first) {
            ImageTransform transform;
            for (std::size_t k = 0; k < pair.order; ++k) {
                transform = transform.then_from_listener(mirrors_[pair.planes[(first + k) % 2]]);
                alternating.images[(first + k) % 2][k] = transform.key();
                if (k >= listed_order_) flutter_images_.push_back(transform.key());
            }
        }
        flutter_.push_back(std::move(alternating));
        flutter_order_ = std::max(flutter_order_, pair.order);
    }
    std::sort(flutter_images_.begin(), flutter_images_.end());
}

SpecularPaths::Planes SpecularPaths::Alternating::planes(std::size_t last,
                                                         std::size_t of_order) const {
    return Planes(sequence).subspan((last + of_order + 1) % 2, of_order);
}

void SpecularPaths::discover(const Vec3& listener, std::uint64_t frame, WorkerPool* workers) {
    frame_ = frame;
    if (listed_order_ == order_) return;
    const ScrambledSobol sobol(derive_seed(seed_, frame));
    RandomStream random(derive_seed(seed_, frame, 1));
    std::vector<Chain> chains(kChains);
    for (std::uint32_t i = 0; i < kChains; ++i) {
        // Start points fill the whole sphere. From its centre alone, sequences that are valid there
        // would be met first, and their neighbours would be left to the rays as well.
        const auto radius_m = static_cast<float>(radius_m_ * std::cbrt(double{random.uniform()}));
        const Vec3 point = listener + radius_m * uniform_direction(random.uniform_2d());
        chains[i].ray = {.origin = point, .direction = uniform_direction(sobol.point(i))};
    }
    run_parts(workers, [&](std::size_t part, std::size_t parts) {
        const std::size_t first = kChains * part / parts;
        const std::size_t end = kChains * (part + 1) / parts;
        extend(listener, std::span(chains).subspan(first, end - first));
    });
    for (std::size_t order = listed_order_ + 1; order <= order_; ++order) {
        for (const Chain& chain : chains) {
            if (chain.keys.size() < order) continue;
            const auto sequence = [&] {
                return Sequence(chain.planes.begin(), chain.planes.begin() + std::ptrdiff_t(order));
            };
            const auto entry = discovered_.find(chain.keys[order - 1]);
            if (entry == discovered_.end()) {
                discovered_.try_emplace(chain.keys[order - 1], sequence(), frame_);
            } else if (Discovered& known = entry->second;
                       known.last_frame.load(std::memory_order_relaxed) < frame_) {
                // Parts of the room differ in the order of planes: a new one replaces an unused
                // one.
                known.sequence = sequence();
                known.last_frame.store(frame_, std::memory_order_relaxed);
            }
        }
    }
    evict();
}

/// Follows the rays of chains over mirror reflections, up to order_.
void SpecularPaths::extend(const Vec3& listener, std::span<Chain> chains) const {
    std::vector<Chain*> alive;
    for (Chain& chain : chains) {
        if (!scene_.visible(listener, chain.ray.origin)) chain.ray.origin = listener;
        alive.push_back(&chain);
    }
    const auto reflect = [&](Chain* chain, const Ray& ray, const Hit& hit) {
        if (!hit.any()) return false;
        const std::uint32_t plane = planes_.of_triangle(hit.triangle);
        const Material& material = scene_.material(scene_.triangle(hit.triangle));
        if (plane == ScenePlanes::kNoPlane || planes_[plane].is_facet() ||
            mirrored_share(material).max() <= 0) {
            return false;
        }
        if (!chain->planes.empty() && chain->planes.back() == plane) return false;
        chain->planes.push_back(plane);
        chain->transform = chain->transform.then_from_listener(mirrors_[plane]);
        chain->keys.push_back(chain->transform.key());
        chain->ray = {.origin = scene_.point(hit, ray.direction),
                      .direction = mirror(ray.direction, scene_.facing_normal(hit, ray.direction))};
        return chain->planes.size() < order_;
    };
    follow_rays(
        scene_, alive, [](const Chain* chain) { return chain->ray; }, reflect);
}

/// Keeps the candidates that are new or near a valid path, then those that were last near one most
/// recently.
/// Ties are broken by the lowest order and the smallest key, which do not depend on the positions
/// of source and listener.
void SpecularPaths::evict() {
    if (discovered_.size() <= kMaxDiscovered) return;
    std::vector<std::tuple<std::uint64_t, std::size_t, std::uint64_t>> ranks;  // age, order, key
    ranks.reserve(discovered_.size());
    for (const auto& [key, candidate] : discovered_) {
        const std::uint64_t last_frame = candidate.last_frame.load(std::memory_order_relaxed);
        ranks.emplace_back(frame_ - std::min(last_frame, frame_), candidate.sequence.size(), key);
    }
    const auto kept = ranks.begin() + kMaxDiscovered;
    std::nth_element(ranks.begin(), kept, ranks.end());
    for (auto i = kept; i != ranks.end(); ++i) discovered_.erase(std::get<2>(*i));
}

SpecularSound SpecularPaths::find(const Vec3& source, const Vec3& listener, bool direct,
                                  const Bands& attenuation_per_m, WorkerPool* workers,
                                  std::size_t sources) const {
    SpecularSound sound;
    if (direct && scene_.visible(listener, source)) {
        const Point offset = Point(source) - Point(listener);
        const double length_m = glm::length(offset);
        sound.paths.push_back({.kind = SoundPath::Kind::direct,
                               .order = 0,
                               .length_m = static_cast<float>(length_m),
                               .direction = near_direction(offset),
                               .energy = spread_over(length_m, attenuation_per_m),
                               .is_main = true,
                               .departure = -near_direction(offset)});
    }
    std::vector<SpecularSound> found(workers ? static_cast<std::size_t>(workers->threads()) : 1);
    run_parts(workers, [&](std::size_t part, std::size_t parts) {
        const auto of_part = [&](std::uint64_t image) { return image % parts == part; };
        found[part] =
            find_images(source, listener, attenuation_per_m, kMaxFlutter / sources, of_part);
    });
    for (const SpecularSound& images : found) {
        sound.paths.insert(sound.paths.end(), images.paths.begin(), images.paths.end());
        sound.tried.insert(sound.tried.end(), images.tried.begin(), images.tried.end());
        sound.reflections += images.reflections;
    }
    std::sort(sound.tried.begin(), sound.tried.end());
    const auto rank = [](const SoundPath& p) { return std::tie(p.length_m, p.order, p.key); };
    std::sort(sound.paths.begin(), sound.paths.end(),
              [&](const SoundPath& a, const SoundPath& b) { return rank(a) < rank(b); });
    return sound;
}

/// The audible images of those whose keys are `wanted`, in any order.
template <typename Wanted>
SpecularSound SpecularPaths::find_images(const Vec3& source, const Vec3& listener,
                                         const Bands& attenuation_per_m, std::size_t flutter_images,
                                         const Wanted& wanted) const {
    SpecularSound sound;
    std::unordered_set<std::uint64_t> images;
    std::vector<Probe> probes;
    std::vector<Point> work;
    const auto probe = [&](Planes sequence, std::uint64_t image) {
        if (!images.insert(image).second) return;
        probes.emplace_back(image, sequence.size(), Point(listener),
                            image_of(Point(source) + kNudge_m, sequence));
    };
    const auto passes = [&](const Sequence& sequence, double reach_m) {
        sound.reflections += sequence.size();
        images_of(Point(source), sequence, work);
        return is_near(sequence, work, Point(listener), reach_m);
    };
    for (const auto& [sequence, image] : listed_) {
        if (wanted(image) && passes(sequence, kBesidePlane_m)) probe(sequence, image);
    }
    const auto try_image = [&](Planes sequence, std::uint64_t image) {
        sound.tried.push_back(image);
        probe(sequence, image);
    };
    for (const auto& [image, candidate] : discovered_) {
        if (!wanted(image) || !passes(candidate.sequence, radius_m_)) continue;
        candidate.last_frame.store(frame_ + 1, std::memory_order_relaxed);
        try_image(candidate.sequence, image);
    }
    std::vector<const Alternating*> around;
    for (const Alternating& alternating : flutter_)
        if (is_between(alternating, Point(source)) && is_between(alternating, Point(listener)))
            around.push_back(&alternating);
    const std::size_t most_orders =
        listed_order_ + flutter_images / (2 * std::max<std::size_t>(around.size(), 1));
    for (const Alternating* const pair : around) {
        const Alternating& alternating = *pair;
        for (std::size_t last = 0; last < 2; ++last) {
            images_of(Point(source), alternating.planes(last, alternating.order()), work);
            const std::size_t last_order = std::min(alternating.order(), most_orders);
            for (std::size_t order = listed_order_ + 1; order <= last_order; ++order) {
                const std::uint64_t image = alternating.images[last][order - 1];
                const Planes sequence = alternating.planes(last, order);
                if (!wanted(image) ||
                    glm::distance(work[order - 1], Point(listener)) > flutter_m_ ||
                    !is_near(sequence, std::span(work).first(order), Point(listener), radius_m_))
                    continue;
                sound.reflections += order;
                try_image(sequence, image);
            }
        }
    }
    follow(probes, source, listener);

    for (const Probe& found : probes) {
        const Point offset = image_of(Point(source), found.planes) - Point(listener);
        const double length_m = glm::length(offset);
        sound.paths.push_back({.kind = SoundPath::Kind::image,
                               .order = static_cast<int>(found.order),
                               .length_m = static_cast<float>(length_m),
                               .direction = near_direction(offset),
                               .energy = found.energy * spread_over(length_m, attenuation_per_m),
                               .key = found.image,
                               .departure = -near_direction(towards_source(offset, found.planes))});
    }
    return sound;
}

std::uint64_t SpecularPaths::key_of(const Sequence& sequence) const {
    ImageTransform transform;
    for (const std::uint32_t plane : sequence) {
        transform = transform.then_from_listener(mirrors_[plane]);
    }
    return transform.key();
}

/// The source mirrored from the last plane to the first.
Point SpecularPaths::image_of(const Point& source, Planes sequence) const {
    Point image = source;
    for (auto plane = sequence.rbegin(); plane != sequence.rend(); ++plane)
        image = planes_[*plane].mirror(image);
    return image;
}

/// The source mirrored in the last plane, in the last two, and so on.
void SpecularPaths::images_of(const Point& source, Planes sequence,
                              std::vector<Point>& images) const {
    images.clear();
    Point image = source;
    for (auto plane = sequence.rbegin(); plane != sequence.rend(); ++plane)
        images.push_back(image = planes_[*plane].mirror(image));
}

/// The direction in which a path that leaves the listener reaches the source: mirrored from the
/// first plane to the last.
Point SpecularPaths::towards_source(const Point& from_listener, const Sequence& sequence) const {
    Point direction = from_listener;
    for (const std::uint32_t plane : sequence) {
        const Point& normal = planes_[plane].normal;
        direction -= 2 * glm::dot(direction, normal) * normal;
    }
    return direction;
}

/// Whether a point is between two planes, or outside by no more than the listener's sphere. Rays
/// have the flutter that is heard beyond the planes.
bool SpecularPaths::is_between(const Alternating& alternating, const Point& point) const {
    for (std::size_t i = 0; i < 2; ++i) {
        const ScenePlanes::Plane& plane = planes_[alternating.sequence[i]];
        if (alternating.side[i] * plane.distance_m(point) < -radius_m_) return false;
    }
    return true;
}

/// Whether the path along a sequence may be valid at a point within `reach_m` of the listener: its
/// reflection points are outside the bounds of their planes by no more than the projection of a
/// sphere of that radius. No ray is traced. The images of the source, those of images_of(), give
/// the reflection points in order from the listener: the segment to each points at the image
/// through the remaining planes.
bool SpecularPaths::is_near(Planes sequence, std::span<const Point> images, const Point& listener,
                            double reach_m) const {
    Point from = listener;
    for (std::size_t k = 0; k < sequence.size(); ++k) {
        const ScenePlanes::Plane& plane = planes_[sequence[k]];
        const Point& image = images[sequence.size() - 1 - k];
        const double side = plane.distance_m(image) < 0 ? 1 : -1;
        const double here_m = side * plane.distance_m(from);
        const double behind_m = -side * plane.distance_m(image);
        if (here_m < -reach_m || !(here_m + behind_m > 0)) return false;
        const Point at = from + (image - from) * (here_m / (here_m + behind_m));
        const double outside_m =
            std::max(largest(Point(plane.bounds.min) - at), largest(at - Point(plane.bounds.max)));
        if (outside_m > kBesidePlane_m) {
            // A sphere that shifts a reflection point by R across the path shifts it by R / cos in
            // the plane.
            const double cosine = (here_m + behind_m) / glm::distance(from, image);
            if (outside_m * cosine > reach_m) return false;
        }
        from = at;
    }
    return true;
}

/// Traces probes until they reach the source, and removes those that do not.
void SpecularPaths::follow(std::vector<Probe>& probes, const Vec3& source,
                           const Vec3& listener) const {
    std::vector<Probe> arrived;
    const auto segment = [&](const Probe& probe) -> Ray {
        const bool last = probe.planes.size() == probe.order;
        const Point offset = (last ? Point(source) : probe.target) - Point(probe.origin);
        const auto length_m = static_cast<float>(glm::length(offset));
        return {probe.origin, ray_direction(last ? offset : probe.target - probe.at),
                last ? length_m - tolerances::kOffset_m : length_m};
    };
    follow_rays(scene_, probes, segment, [&](Probe& probe, const Ray& ray, const Hit& hit) {
        if (probe.planes.size() < probe.order) return reflect(probe, ray, hit);
        if (!hit.any()) arrived.push_back(std::move(probe));
        return false;
    });
    std::erase_if(arrived, [&](const Probe& probe) {
        const auto is_on = [&](const Vec3& point, std::uint32_t plane) {
            return std::abs(planes_[plane].distance_m(Point(point))) < kOnPlane_m;
        };
        return key_of(probe.planes) != probe.image || is_on(listener, probe.planes.front()) ||
               is_on(source, probe.planes.back());
    });
    probes = std::move(arrived);
}

/// Moves a probe to its next segment. False if there is none.
bool SpecularPaths::reflect(Probe& probe, const Ray& ray, const Hit& hit) const {
    if (!hit.any()) return false;
    const std::uint32_t index = planes_.of_triangle(hit.triangle);
    if (index == ScenePlanes::kNoPlane || planes_[index].is_facet()) return false;
    if (!probe.planes.empty() && probe.planes.back() == index) return false;
    const RayScene::Triangle& triangle = scene_.triangle(hit.triangle);
    probe.energy *= mirrored_share(scene_.material(triangle));
    if (probe.energy.max() <= 0) return false;

    // The intersection of the plane and the straight line to the image.
    const ScenePlanes::Plane& plane = planes_[index];
    const double here_m = plane.distance_m(probe.at);
    const double there_m = plane.distance_m(probe.target);
    if (here_m == there_m) return false;
    probe.at += (probe.target - probe.at) * std::clamp(here_m / (here_m - there_m), 0.0, 1.0);
    probe.target = plane.mirror(probe.target);
    probe.planes.push_back(index);

    // The next segment starts on this one, before the hit, so that no segment passes a wall at its
    // edge.
    const float cosine = std::abs(glm::dot(ray.direction, triangle.normal));
    const float back_m =
        std::min(RayScene::offset_after(hit.distance_m) / cosine, hit.distance_m / 2);
    probe.origin = ray.origin + (hit.distance_m - back_m) * ray.direction;
    return true;
}

}  // namespace aula
