#include "engine/direct/direct_sound.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <utility>

#include "engine/direct/followed_taps.h"
#include "engine/rays/wall_crossing.h"

namespace aula {

namespace {

bool is_same_tap(const SoundPath& a, const SoundPath& b) {
    return a.length_m == b.length_m && a.direction == b.direction && a.energy == b.energy &&
           a.key == b.key && a.is_main == b.is_main && a.edges == b.edges &&
           a.departure == b.departure && a.apexes == b.apexes;
}

}  // namespace

DirectSound::DirectSound(const RayScene& scene, float speed_of_sound_m_s, int order)
    : scene_(scene),
      edges_(scene),
      paths_(scene, edges_, double{speed_of_sound_m_s}),
      reflections_(scene, edges_, paths_, double{speed_of_sound_m_s}),
      chains_(scene, edges_, double{speed_of_sound_m_s}, order) {
    std::map<std::uint32_t, MovableObject> movable;
    for (std::uint32_t t = 0; t < scene.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = scene.triangle(t);
        if (scene.moves(triangle)) movable[triangle.object].triangles.push_back(t);
    }
    for (auto& [_, object] : movable) {
        follow(object);
        movable_.push_back(std::move(object));
    }
}

void DirectSound::begin_frame(bool moved) {
    changed_.clear();
    if (moved) find_changes();
    chains_.begin_frame(changed_);
    ++frames_;
}

void DirectSound::find_changes() {
    ++scene_version_;
    edges_.scene_moved();
    for (MovableObject& object : movable_) {
        if (object.corners == scene_.triangle(object.triangles[0]).vertices) continue;
        Bounds swept = object.bounds;
        follow(object);
        swept.add(object.bounds.min);
        swept.add(object.bounds.max);
        changed_.push_back(swept);
    }
}

void DirectSound::follow(MovableObject& object) {
    object.corners = scene_.triangle(object.triangles[0]).vertices;
    object.bounds = {};
    for (const std::uint32_t t : object.triangles) object.bounds.add(scene_.triangle(t).vertices);
}

/// All that a frame leaves is a function of the inputs and of what the frames before left. If
/// nothing changes in as many frames as test all edges, nothing will change in the next one.
std::vector<SoundPath> DirectSound::find(const Vec3& source, const Vec3& listener,
                                         const OrientedDirectivity& directivity,
                                         const Bands& attenuation_per_m, PairMemory& memory) const {
    const PairMemory::Inputs inputs{source, listener, directivity, scene_version_};
    const bool rests = memory.inputs == inputs;
    memory.inputs = inputs;
    if (std::exchange(memory.materials, materials_) != materials_) memory.levels = {};
    if (rests && memory.equal_frames >= NearEdges::kTurns) {
        memory.near.skip_frame();
        return memory.taps;
    }
    std::vector<SoundPath> taps = compute(source, listener, directivity, attenuation_per_m, memory);
    const bool is_equal =
        rests && !memory.near.has_changed() && memory.levels.is_exact() &&
        memory.chains.is_complete() &&
        std::equal(taps.begin(), taps.end(), memory.taps.begin(), memory.taps.end(), is_same_tap);
    memory.equal_frames = is_equal ? memory.equal_frames + 1 : 0;
    memory.taps = taps;
    return taps;
}

std::vector<SoundPath> DirectSound::compute(const Vec3& source, const Vec3& listener,
                                            const OrientedDirectivity& directivity,
                                            const Bands& attenuation_per_m,
                                            PairMemory& memory) const {
    std::vector<EdgePath> paths =
        paths_.find(source, listener, attenuation_per_m, memory, changed_);
    const auto chains = chains_.find(source, listener, memory.chains, attenuation_per_m, paths);
    paths.insert(paths.end(), chains.begin(), chains.end());
    chains_.join_rows(source, listener, memory.chains, attenuation_per_m, paths);
    const double straight_m = double{glm::distance(source, listener)};
    Bands model = paths_.limit(paths, straight_m, attenuation_per_m);
    std::optional<SoundPath> through_walls =
        path_through_walls(scene_, source, listener, attenuation_per_m);
    if (through_walls) {
        model += through_walls->energy;
        through_walls->energy *= directivity.factor(through_walls->departure);
    }
    if (!directivity.is_omnidirectional()) {
        for (EdgePath& path : paths) {
            const Bands factor = directivity.factor(path.departure);
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const double share = std::sqrt(double{factor[b]});
                path.field[b] *= share;
                for (ComplexBands& reflected : path.reflected) reflected[b] *= share;
            }
        }
    }
    memory.reflections.bent = paths;
    std::erase_if(memory.reflections.bent,
                  [](const EdgePath& path) { return path.edges.size() != 1; });
    return followed_taps(paths_, paths, model, source, listener, !changed_.empty(), memory,
                         through_walls);
}

void DirectSound::complete_reflections(std::vector<SoundPath>& paths, const Vec3& source,
                                       const Vec3& listener, const FirstOrderImages& images,
                                       const OrientedDirectivity& directivity,
                                       const Bands& attenuation_per_m, PairMemory& memory) const {
    reflections_.complete(paths, source, listener, images, directivity, attenuation_per_m,
                          !changed_.empty(), memory);
}

}  // namespace aula
