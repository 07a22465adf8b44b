#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "aula/engine/bands.h"
#include "engine/rays/image_transform.h"
#include "engine/rays/ray_scene.h"
#include "engine/trace/path_identifier.h"

namespace aula {

/// Paths of one reflection order as a structure of arrays for vector units. The stages (intersect,
/// arrive, scatter, leave) process the whole batch: wavefront path tracing (Laine et al. 2013).
/// Each lane's result depends on its own path only. [propagation thread]
struct PathBatch {
    /// Russian roulette begins below this share of the initial energy in every band (-30 dB). From
    /// there on, of a reflection that leaves the share r of the energy, the share sqrt(r) of the
    /// paths survives with the share sqrt(r) of the energy of each.
    static constexpr float kRouletteEnergy = 1e-3F;

    /// The least of the uniform numbers that choose a lobe, half a step of them: at 0 a lobe of
    /// nearly zero energy could be chosen.
    static constexpr float kLeastChoice = 0x1p-25F;

    /// Where a reflection sends a path.
    enum class Lobes {
        one,      ///< to one lobe, chosen at random
        both,     ///< the same; but a path that only mirrors have reflected goes on in the mirror
                  ///< direction in any case (take_mirrored), so that its energy needs no weight
        mirrored  ///< in the mirror direction
    };

    std::size_t count = 0;  ///< lanes in use
    Lobes lobes = Lobes::one;
    bool behind_walls = false;  ///< the paths have passed walls (TransmittedPaths)

    // Paths.
    RayLanes rays;                            ///< next segments
    std::array<std::uint32_t, kLanes> ray{};  ///< index in the batch
    std::array<Bands, kLanes> energy{};
    alignas(64) std::array<float, kLanes> length_m{};         ///< up to the present hit
    alignas(64) std::array<std::uint64_t, kLanes> random{};   ///< state of each path's generator
    alignas(64) std::array<std::uint32_t, kLanes> diffuse{};  ///< 1 after a diffuse reflection
    std::array<PathIdentifier, kLanes> identifier{};
    std::array<ImageTransform, kLanes> image{};  ///< for orders up to that of the image sources
    /// The energy of the strongest band below which a path is in roulette: that of its last
    /// reflection or, before, where roulette begins. Less behind walls.
    alignas(64) std::array<float, kLanes> roulette_energy = filled(kRouletteEnergy);
    /// Lobes::both: of a path that only mirrors have reflected, the probability that the diffuse
    /// lobe has not been chosen yet.
    alignas(64) std::array<float, kLanes> undivided{};
    std::array<std::uint32_t, kLanes> crossings{};  ///< walls passed, of paths behind walls
    std::array<std::uint32_t, kLanes> reflected{};  ///< the same: 1 after any reflection

    // Hits of the paths.
    HitLanes hits;
    LanePoints point;   ///< off the surface, RayScene::point_off
    LanePoints normal;  ///< RayScene::facing_normal
    std::array<std::uint32_t, kLanes> material{};
    alignas(64) std::array<std::uint32_t, kLanes> back{};  ///< 1 at a triangle's back
    std::array<Bands, kLanes> scattered{};                 ///< energy s (1 - alpha) E
    std::array<Bands, kLanes> specular{};              ///< Lobes::both: energy (1 - s)(1 - alpha) E
    alignas(64) std::array<float, kLanes> choice{};    ///< uniform, selects the lobe
    alignas(64) std::array<float, kLanes> roulette{};  ///< uniform
    alignas(64) std::array<std::uint32_t, kLanes> to_diffuse{};  ///< 1 where the path continues
                                                                 ///< diffusely, then that of the
                                                                 ///< last reflection
    std::array<std::uint32_t, kLanes> ended{};

    /// Removes the paths whose ray hits nothing. The last path moves to a removed path's lane.
    void remove_escaped();

    /// Removes the paths that have ended at the last reflection, in the same way.
    void remove_ended();

    /// Appends a path of another batch that has left its last hit.
    void append(const PathBatch& from, std::size_t lane);

    /// Appends the specular part of each path of a batch with Lobes::both that its last reflection
    /// sends to the diffuse lobe for the first time, after scatter() and before leave(). The
    /// roulette of both begins at the same energy.
    void take_mirrored(const PathBatch& from, float max_length_m);

    /// Advances to the hits, which all lanes must have: sets `point`, `normal`, `back` and the
    /// lengths.
    void arrive(const RayScene& scene);

    /// Reflects: applies air attenuation and absorption, and selects the lobe of each path.
    void scatter(const RayScene& scene, const Bands& attenuation_per_m);

    /// Sets the next segments, which end at a path length of `max_length_m`.
    void leave(float max_length_m);

 private:
    static constexpr std::array<float, kLanes> filled(float value) {
        std::array<float, kLanes> all{};
        all.fill(value);
        return all;
    }
    void set_path(std::size_t lane, const PathBatch& from, std::size_t other);
    void remove(std::size_t lane);
};

}  // namespace aula
