#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/bands.h"
#include "engine/rays/image_transform.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/path_identifier.h"

namespace aula {

/// Paths of one reflection order, side by side, so that vector units take many of them at once: a
/// batch goes from hit to hit. Lane by lane what happens to a path depends on that path alone.
/// [propagation thread]
struct PathBatch {
    /// A ray below this share of its first energy in every band (-80 dB) plays roulette.
    static constexpr float kRouletteEnergy = 1e-8F;

    std::size_t count = 0;  ///< lanes in use

    // The paths.
    RayLanes rays;                            ///< next segments
    std::array<std::uint32_t, kLanes> ray{};  ///< number in the batch
    std::array<Bands, kLanes> energy{};
    alignas(64) std::array<float, kLanes> length_m{};         ///< so far
    alignas(64) std::array<std::uint64_t, kLanes> random{};   ///< state of each path's generator
    alignas(64) std::array<std::uint32_t, kLanes> diffuse{};  ///< 1 after a diffuse reflection
    std::array<PathIdentifier, kLanes> identifier{};
    std::array<ImageTransform, kLanes> image{};  ///< up to the image sources' order

    // Their hits.
    HitLanes hits;
    LanePoints point;   ///< off the surface, RayScene::point_off
    LanePoints normal;  ///< RayScene::facing_normal
    std::array<std::uint32_t, kLanes> material{};
    alignas(64) std::array<std::uint32_t, kLanes> back{};  ///< 1 where they met a triangle's back
    std::array<Bands, kLanes> scattered{};                 ///< energy s (1 - alpha) E
    alignas(64) std::array<float, kLanes> choice{};        ///< uniform, of the lobe
    alignas(64) std::array<float, kLanes> roulette{};      ///< uniform
    alignas(64) std::array<std::uint32_t, kLanes> to_diffuse{};  ///< 1 where it goes on diffusely,
                                                                 ///< then of the last reflection
    std::array<std::uint32_t, kLanes> ended{};

    /// Takes a path out; the last one moves to its lane.
    void remove(std::size_t lane);

    /// Goes to the hits, which all lanes must have: `point`, `normal`, `back`, lengths.
    void arrive(const RayScene& scene);

    /// Reflects: energies through the air and at the surface, the lobe that a path goes on in.
    void scatter(const RayScene& scene, const Bands& attenuation_per_m);

    /// Sets the next segments, which end where a path is `max_length_m` long.
    void leave(float max_length_m);
};

}  // namespace aula
