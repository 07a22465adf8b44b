#pragma once

#include <memory>
#include <span>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/frame.h"
#include "aula/engine/scene.h"

namespace aula {

/// The propagation engine. One step() per frame traces rays, updates the caches and computes the
/// energy response of every source at every listener. The same scene, seed and inputs give results
/// that are identical to the bit with any number of threads. One thread at a time may use an
/// object, apart from the worker threads that it starts (Simulation::threads).
///
/// Sources have indices in the order of their addition, those of the scene first. Indices are not
/// checked.
class Propagation {
 public:
    /// Copies the scene; `simulation` replaces Scene::simulation. Unless Simulation::ir_length_s is
    /// set, it traces sound until it has decayed between all positions of the scene's sources and
    /// its listener, and at `receivers`, for responses_at(). `listener_count` is at least 1. Throws
    /// InputError if a setting is out of range.
    Propagation(const Scene& scene, const Simulation& simulation, std::size_t listener_count = 1,
                std::span<const Vec3> receivers = {});
    ~Propagation();
    Propagation(const Propagation&) = delete;
    Propagation& operator=(const Propagation&) = delete;

    /// Appends a source. Its responses are silent until the next step(), whose input has one
    /// position more. `pose` is where it will be then; caches are prepared for it. The memory of
    /// the caches is divided anew. Patches keep the size that was chosen for the scene's sources.
    void add_source(const Pose& pose, const Directivity& directivity = {});

    /// Removes a source; the indices of later sources decrease by one.
    void remove_source(std::size_t source);

    /// Number of sources at present.
    std::size_t source_count() const;

    /// Gives all triangles of an object one material from the next frame on. `object` is its index
    /// in Scene::objects. Caches with the old material are cleared, as after a large movement. The
    /// length of the responses does not change.
    void set_object_material(std::size_t object, const Material& material);

    /// Replaces the coefficients of a material from the next frame on, with the same consequences.
    /// `material` is its index in Scene::materials.
    void change_material(std::size_t material, const Material& coefficients);

    /// Propagates one frame. The input has a position for each source and listener. Results are
    /// valid until the next step.
    void step(const FrameInput& input);

    /// The newest response of a source at a listener; silent before the first step. Any thread may
    /// call it, but not in parallel with step().
    const EnergyResponse& response(std::size_t source, std::size_t listener = 0) const;

    /// The responses of all sources at receivers that are not listeners, [source * receivers.size()
    /// + receiver]: one gather for each receiver from the caches after the newest step(), whose
    /// input is `input`. Receivers have no state, and an unlimited number of them can be used.
    /// Requires a step(). Throws InputError for other estimators than Estimator::patch.
    std::vector<EnergyResponse> responses_at(const FrameInput& input,
                                             std::span<const Vec3> receivers);

    /// Clears all caches and responses. The next step is frame 0 with that seed.
    void restart(std::uint64_t seed);

    /// Cost of the newest frame; its segments and bins include those of responses_at() since.
    const FrameStatistics& statistics() const;

    /// The first `count` paths of the newest frame from a source, up to the reflection order
    /// `order`, for display. `input` is the input of that frame. Empty before the first frame.
    std::vector<PathLine> path_lines(const FrameInput& input, std::size_t source, int count,
                                     int order) const;

    /// The energy that each patch radiates for a source from `begin_s` to `end_s` after the
    /// emission, for display. Empty for estimators without patches.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    /// The edges that diffract sound, with all objects at their positions in the newest frame, for
    /// display.
    std::vector<EdgeLine> edge_lines() const;

    /// Edge length of the patches in m, which Simulation::memory_mb may have increased; 0 for
    /// estimators without patches.
    float patch_size_m() const;

    /// [source] 1 if sound can reach the first listener of `input`, with all objects at their
    /// positions in the newest frame, else 0. Found by random walks that cannot pass a wall by
    /// rounding.
    std::vector<char> sources_connected(const FrameInput& input) const;

    /// Sets the rays per source from the next frame on, 1 to Simulation::kMaxRays.
    void set_rays(int rays);

    /// From the next frame on, rays start at listeners rather than at static sources, whose caches
    /// then need no memory: for many sources and few listeners. Responses to a moving listener are
    /// noisier. Estimators other than Estimator::patch ignore it.
    void emit_from_listeners();

    /// Length of the responses: Simulation::ir_length_s, or the time in which the sound of every
    /// octave band decays by 70 dB, within 0.3 and 10 s.
    double response_length_s() const;

 private:
    friend class FrameRays;  // of the benchmarks
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
