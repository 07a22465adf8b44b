#pragma once

#include <memory>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/frame.h"
#include "aula/engine/scene.h"

namespace aula {

struct Ray;

/// The propagation engine. One step() per frame traces rays, updates the caches and computes the
/// energy response of every source at every listener. Deterministic: the same scene, seed and
/// inputs give bit-identical results with any number of threads. [propagation thread]
class Propagation {
 public:
    /// Throws InputError if the settings are invalid.
    Propagation(const Scene& scene, const Simulation& simulation, std::size_t listener_count = 1);
    ~Propagation();
    Propagation(const Propagation&) = delete;
    Propagation& operator=(const Propagation&) = delete;

    /// Appends a source, at its position in the next frame. Its responses are silent until then.
    /// The caches' memory is divided anew; patches keep their size, which was chosen for the
    /// scene's sources.
    void add_source(const Vec3& position);

    /// Removes a source; the indices of later sources decrease by one.
    void remove_source(std::size_t source);

    std::size_t source_count() const;

    /// Sets an object's material, or changes the coefficients of a material of the scene, from the
    /// next frame on. Caches with the old material are cleared, as after a large movement; the
    /// responses keep their length.
    void set_object_material(std::size_t object, const Material& material);
    void change_material(std::size_t material, const Material& coefficients);

    /// Propagates one frame. Results are valid until the next step.
    void step(const FrameInput& input);

    /// The newest response. [any thread, not in parallel with step()]
    const EnergyResponse& response(std::size_t source, std::size_t listener = 0) const;

    /// Clears all caches; the next step is frame 0 with another seed, derived from `seed`.
    void restart(std::uint64_t seed);

    const FrameStatistics& statistics() const;

    /// The rays that the next step() will emit if nothing in the scene moves, path by path, then
    /// those of the gather. For the benchmark, which traces them again.
    std::vector<Ray> rays(const FrameInput& input) const;

    /// The first `count` of the newest frame's paths from a source, up to reflection order `order`,
    /// for display. `input` is that frame's.
    std::vector<PathLine> path_lines(const FrameInput& input, std::size_t source, int count,
                                     int order) const;

    /// The energies that the patches radiate for a source within a time interval after emission,
    /// for display; empty for estimators without patches.
    std::vector<PatchEnergy> patch_energies(std::size_t source, double begin_s, double end_s) const;

    /// Edge length of the patches; 0 for estimators without patches.
    float patch_size_m() const;

    /// For each source, whether sound can reach the first listener with all objects at their
    /// positions in the newest frame. Uses random walks that cannot pass a wall by rounding.
    std::vector<char> sources_connected(const FrameInput& input) const;

    /// Sets the rays per source from the next frame on.
    void set_rays(int rays);

    /// Length of the responses: as set, or from the room's reverberation time, at most 4 s.
    double response_length_s() const;

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
