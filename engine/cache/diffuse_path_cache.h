#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "aula/engine/energy_response.h"
#include "engine/trace/specular_paths.h"
#include "engine/trace/trace_batch.h"

namespace aula {

/// The diffuse path cache of one source and one listener: a hash table from path identifiers to
/// sums over the arrivals along each path. All sums are 64-bit fixed point, so that addition and
/// removal are exact. [propagation thread]
class DiffusePathCache {
 public:
    enum class Readout {
        published,  ///< Eq. 3.2 as printed: an entry counts rays since it was inserted
        windowed,   ///< the arrivals of the last frames over the rays of those frames
    };

    struct Entry {
        std::int64_t arrival_count = 0;                     ///< eta
        std::int64_t emitted_count = 0;                     ///< mu
        std::array<std::int64_t, kBandCount> energy_sum{};  ///< I-hat, see to_fixed()
        std::int64_t length_sum = 0;                        ///< r-hat, in 2^-20 m
        std::array<std::int64_t, 3> intensity_sum{};        ///< see DirectionMoments::intensity
        std::int64_t inserted_frame = 0;
        std::uint64_t image = 0;  ///< see Arrival
    };

    /// `window_frames` >= 1 is F, the lifetime of an entry or the length of the window. If the
    /// cache exceeds `memory_bytes`, the oldest data is removed first.
    DiffusePathCache(Readout readout, int window_frames, std::size_t memory_bytes);
    ~DiffusePathCache();
    DiffusePathCache(DiffusePathCache&&) noexcept;
    DiffusePathCache& operator=(DiffusePathCache&&) noexcept;

    /// Sets the memory limit from the next frame on.
    void set_memory_bytes(std::size_t memory_bytes);

    /// Processes one frame: removes expired data, adds the arrivals, and adds `rays`, the number
    /// emitted by the source in this frame, to every entry's emitted_count.
    void add_frame(std::span<const Arrival> arrivals, int rays);

    /// Adds every entry that no image source counts to a response, as a delayed impulse.
    void add_to(const SpecularSound& images, EnergyResponse& response) const;

    std::size_t size() const;
    std::size_t memory_bytes() const;
    const Entry* find(const PathIdentifier& path) const;

    /// Converts an energy to fixed point, in units of 2^-32 1/m2.
    static std::int64_t to_fixed(float energy);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
