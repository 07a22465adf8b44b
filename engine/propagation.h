#pragma once

#include <memory>
#include <vector>

#include "engine/estimate/frame.h"
#include "engine/estimate/frame_view.h"
#include "engine/rays/ray_scene.h"
#include "engine/response/energy_response.h"
#include "engine/scene/scene.h"
#include "engine/trace/path_tracer.h"

namespace aula {

/// The propagation engine: one step() a frame traces rays from every source, updates the caches
/// and gives the energy response of every source at every listener. Deterministic: the same scene,
/// seed and inputs give the same bits with any number of threads. [propagation thread]
class Propagation {
 public:
    /// Throws Error if the settings cannot be used.
    Propagation(const Scene& scene, const Simulation& simulation, std::size_t listener_count = 1);
    ~Propagation();
    Propagation(const Propagation&) = delete;
    Propagation& operator=(const Propagation&) = delete;

    /// Adds a source behind the others, at its place in the next frame. Its responses are silent
    /// until then. Bounds of the caches' memory are divided anew; patches keep their size, which
    /// was chosen for the sources of the scene.
    void add_source(const Vec3& position);

    /// Removes a source; the index of each behind it falls by one.
    void remove_source(std::size_t source);

    std::size_t source_count() const;

    /// Gives an object of the scene another material from the next frame on, or a material of the
    /// scene other coefficients. What is cached of the old one is forgotten, as after a large
    /// movement; the responses keep their length.
    void set_object_material(std::size_t object, const Material& material);
    void change_material(std::size_t material, const Material& coefficients);

    /// Propagates one frame. Results are valid until the next step.
    void step(const FrameInput& input);

    /// The newest response. [any thread, not beside step()]
    const EnergyResponse& response(std::size_t source, std::size_t listener = 0) const;

    /// Forgets everything cached; the next step is frame 0 with another, derived seed.
    void restart(std::uint64_t seed);

    const FrameStatistics& statistics() const;

    /// The rays that the next step() will send if nothing in the scene moves, path by path and then
    /// those of the gather, for the benchmark to trace again.
    std::vector<Ray> rays(const FrameInput& input) const;

    /// The first `count` of the newest frame's paths from a source, up to a reflection order, to be
    /// looked at. `input` is that frame's.
    std::vector<PathLine> path_lines(const FrameInput& input, std::size_t source, int count,
                                     int order) const;

    /// What every patch radiates of a source's sound within a time after emission, to be looked
    /// at; empty for estimators without patches.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    /// Edge of the patches; 0 for estimators without.
    float patch_size_m() const;

    /// For each source, whether sound finds a way to the first listener with everything where the
    /// newest frame had it: by random walks that no rounding takes through a wall.
    std::vector<char> sources_connected(const FrameInput& input) const;

    /// Other rays per source from the next frame on.
    void set_rays(int rays);

    /// Length of the responses: as set, or from the room's reverberation time, at most 4 s.
    double response_length_s() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
