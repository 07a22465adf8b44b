#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "aula/engine/energy_response.h"
#include "engine/base/worker_pool.h"
#include "engine/rays/image_transform.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/scene_planes.h"

namespace aula {

/// Two large planes that face each other and reflect sound alternately.
struct FlutterPair {
    std::array<std::uint32_t, 2> planes{};
    std::size_t order = 0;  ///< of the last image source that is not yet 60 dB below the first
};

/// The pairs of planes with flutter echoes, those of the largest areas first. Objects that move
/// have none. `longest_m` is the length of the longest path.
std::vector<FlutterPair> flutter_pairs(const RayScene& scene, const ScenePlanes& planes,
                                       double longest_m);

/// The direct sound and image sources that are audible at a listener from a source.
struct SpecularSound {
    std::vector<SoundPath> paths;  ///< by ascending length

    /// ImageTransform::key of every image above listed_order() that was tried, ascending. Rays
    /// along these paths do not count, whether or not the image is audible.
    std::vector<std::uint64_t> tried;

    /// Of all candidates that were examined, without those of flutter that are not near.
    std::size_t reflections = 0;

    /// False for key 0.
    bool has_tried(std::uint64_t image) const {
        return std::binary_search(tried.begin(), tried.end(), image);
    }
};

/// Direct sound and image sources up to a specular order. Candidates are sequences of the scene's
/// planes, without facets: planes of less than 0.01 m2, as of curved objects. Rays count the
/// reflections over facets at every order, as means over their detection spheres. Up to
/// listed_order() all sequences are candidates. Above it they are the sequences met by specular
/// chains of rays from the listeners, one per image, and are kept while they are near a valid path.
/// The sequences of flutter_pairs() are candidates beyond order() as well.
/// An image source is audible if a ray towards it is reflected to the source by planes whose
/// composed isometry is the image's, in any order. For each pair of source and listener an image is
/// counted either by its image source or by the estimators' rays (SpecularSound::tried). Candidates
/// do not depend on an estimator's random numbers, so that the rays' part remains unbiased. Equal
/// calls give equal paths. [propagation thread]
class SpecularPaths {
 public:
    /// `order` 0: direct sound only. `radius_m` is the radius of the spheres that detect rays.
    /// `flutter_m` is the length of the longest path with more reflections than `order`, between
    /// the planes of a pair; 0 leaves them to rays.
    SpecularPaths(const RayScene& scene, int order, float radius_m, std::uint64_t seed,
                  double flutter_m = 0);

    /// Removes all discovered candidates.
    void restart(std::uint64_t seed);

    /// Updates the planes after RayScene::move.
    void scene_moved();

    /// Updates the reflecting planes after a change of materials. Removes all discovered
    /// candidates.
    void materials_changed();

    /// Traces chains from a listener and adds the sequences of planes that they meet to the
    /// candidates. Call once per listener and frame, before find(). The number of `workers` does
    /// not change the result.
    void discover(const Vec3& listener, std::uint64_t frame, WorkerPool* workers = nullptr);

    /// Highest order of the image sources other than flutter.
    int order() const { return static_cast<int>(order_); }

    /// Highest order of all image sources.
    int highest_order() const { return std::max(order(), static_cast<int>(flutter_order_)); }

    /// True if rays and image sources share the purely specular paths of an order, by their images.
    bool shares_with_rays() const { return leaves_to_rays(order()) || flutter_order_ > 0; }

    /// True for an image that an image source may count: any up to order(), flutter above.
    bool may_list(const ImageTransform& image) const {
        return image.order <= order_ ||
               std::binary_search(flutter_images_.begin(), flutter_images_.end(), image.key());
    }

    /// Highest order at which every sequence is a candidate, at most order().
    int listed_order() const { return static_cast<int>(listed_order_); }

    /// True if rays count the purely specular paths of an order, or those of them over facets.
    bool leaves_to_rays(int order) const { return order > listed_order() || has_facets_; }

    /// The mirror plane of a triangle, for an ImageTransform. A moving object has a fixed
    /// substitute without symmetries, which keeps the keys constant.
    const MirrorPlane& mirror_of_triangle(std::uint32_t triangle) const {
        return mirrors_[planes_.of_triangle(triangle)];
    }

    const ScenePlanes& planes() const { return planes_; }

    /// [plane] SoundPath::id of the path with one reflection at a plane.
    std::span<const std::uint64_t> first_order_ids() const { return first_order_ids_; }

    /// The direct sound, if `direct` and visible, and the reflections. The energy in each band is
    /// prod (1 - s)(1 - alpha) / (4 pi d^2) times exp(-attenuation d), with d at least 0.1 m. A
    /// source or listener within 0.5 mm of a plane has no reflection in it. The number of `workers`
    /// does not change the result. The flutter of all `sources` shares the number of its images.
    /// [several threads, without `workers`]
    SpecularSound find(const Vec3& source, const Vec3& listener, bool direct,
                       const Bands& attenuation_per_m, WorkerPool* workers = nullptr,
                       std::size_t sources = 1) const;

 private:
    using Sequence = std::vector<std::uint32_t>;    ///< planes from the listener to the source
    using Planes = std::span<const std::uint32_t>;  ///< those of a sequence

    struct Listed {
        Sequence sequence;
        std::uint64_t image;
    };

    /// A discovered sequence of an image, and the last frame in which it is useful: one after the
    /// frame in which it was last near a valid path.
    struct Discovered {
        Discovered(Sequence planes, std::uint64_t frame)
            : sequence(std::move(planes)), last_frame(frame) {}
        Sequence sequence;
        mutable std::atomic<std::uint64_t> last_frame;
    };

    /// The sequences that alternate between two planes.
    struct Alternating {
        Sequence sequence;                                 ///< the longest, and one plane before
        std::array<std::vector<std::uint64_t>, 2> images;  ///< [plane at the source][order - 1]

        std::array<double, 2> side{};  ///< [plane] 1 or -1: on which the other one is

        std::size_t order() const { return images[0].size(); }
        Planes planes(std::size_t last, std::size_t of_order) const;
    };

    /// A ray from a listener over mirror reflections.
    struct Chain;

    /// A ray towards an image source.
    struct Probe;

    void add_mirrors();
    void list_sequences();
    void list_flutter();
    void extend(const Vec3& listener, std::span<Chain> chains) const;
    void evict();
    template <typename Wanted>
    SpecularSound find_images(const Vec3& source, const Vec3& listener,
                              const Bands& attenuation_per_m, std::size_t flutter_images,
                              const Wanted& wanted) const;
    std::uint64_t key_of(const Sequence& sequence) const;
    ScenePlanes::Point image_of(const ScenePlanes::Point& source, Planes sequence) const;
    void images_of(const ScenePlanes::Point& source, Planes sequence,
                   std::vector<ScenePlanes::Point>& images) const;
    ScenePlanes::Point towards_source(const ScenePlanes::Point& from_listener,
                                      const Sequence& sequence) const;
    bool is_between(const Alternating& alternating, const ScenePlanes::Point& point) const;
    bool is_near(Planes sequence, std::span<const ScenePlanes::Point> images,
                 const ScenePlanes::Point& listener, double reach_m) const;
    void follow(std::vector<Probe>& probes, const Vec3& source, const Vec3& listener) const;
    bool reflect(Probe& probe, const Ray& ray, const Hit& hit) const;

    const RayScene& scene_;
    std::size_t order_;
    double radius_m_;
    std::uint64_t seed_;
    double flutter_m_;
    ScenePlanes planes_;
    ScenePlanes::Point middle_;         ///< of the scene; origin of the mirrors
    std::vector<MirrorPlane> mirrors_;  ///< [plane]
    std::vector<std::uint64_t> first_order_ids_;
    bool has_facets_ = false;  ///< some facets reflect
    std::size_t listed_order_ = 0;
    std::vector<Listed> listed_;  ///< all up to listed_order_
    std::vector<Alternating> flutter_;
    std::vector<std::uint64_t> flutter_images_;  ///< those above listed_order_, ascending
    std::size_t flutter_order_ = 0;              ///< the highest of them, 0 without any
    std::unordered_map<std::uint64_t, Discovered> discovered_;  ///< by ImageTransform::key
    std::uint64_t frame_ = 0;                                   ///< of the last discover()
};

}  // namespace aula
