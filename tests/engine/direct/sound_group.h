#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "aula/engine/scene.h"
#include "engine/direct/direct_sound.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/specular_paths.h"
#include "tests/engine/direct/edge_path_scene.h"

namespace aula::test {

inline constexpr float kSpeed_m_s = 343.2F;

inline Scene scene_of(const Object& object,
                      const Material& material = {"rigid", Bands{}, Bands{}}) {
    Scene scene;
    scene.objects = {object};
    scene.materials = {material};
    return scene;
}

/// A scene, and the direct sound and the first-order reflections of a first frame.
struct SoundGroup {
    explicit SoundGroup(const Scene& scene, int specular_order = 1)
        : rays(scene), images(rays, specular_order, 0.5F, 1) {}

    std::vector<SoundPath> direct(const Vec3& source, const Vec3& listener) {
        memory = {};
        sound.begin_frame(false);
        sound.search(source, listener, memory);
        return sound.find(source, listener, {}, Bands{}, memory);
    }

    /// All paths, with or without the diffraction of the reflections.
    std::vector<SoundPath> paths(const Vec3& source, const Vec3& listener, bool grouped) {
        std::vector<SoundPath> all = direct(source, listener);
        const auto found = images.find(source, listener, all.empty(), Bands{}).paths;
        all.insert(all.end(), found.begin(), found.end());
        if (grouped) {
            sound.complete_reflections(all, source, listener,
                                       {images.planes(), images.first_order_ids(), images.order()},
                                       {}, Bands{}, memory);
        }
        return all;
    }

    /// The reflections alone.
    std::vector<SoundPath> reflections(const Vec3& source, const Vec3& listener, bool grouped) {
        std::vector<SoundPath> all = paths(source, listener, grouped);
        std::erase_if(all, [](const SoundPath& path) { return path.order == 0; });
        return all;
    }

    RayScene rays;
    DirectSound sound{rays, kSpeed_m_s, 2};
    SpecularPaths images;
    PairMemory memory;
};

/// Level of the energy of paths relative to free field at a distance, dB.
inline Levels level_db(const std::vector<SoundPath>& paths, double distance_m) {
    Bands sum;
    for (const SoundPath& path : paths) sum += path.energy;
    Levels level;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        level[b] = 10 * std::log10(4 * std::numbers::pi * distance_m * distance_m *
                                   std::max(1e-30, double{sum[b]}));
    }
    return level;
}

}  // namespace aula::test
