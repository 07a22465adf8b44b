#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "engine/response/energy_response.h"
#include "engine/trace/path_tracer.h"

namespace aula {

/// The diffuse path cache of one source and one listener: a hash table from path identifiers to
/// what is known of the sound along each path. All sums are 64-bit fixed point, so that adding and
/// removing is exact. [propagation thread]
class DiffusePathCache {
 public:
    enum class Readout {
        published,  ///< Eq. 3.2 as printed: an entry counts rays since it was inserted
        windowed,   ///< the arrivals of the last frames over the rays of those frames
    };

    struct Entry {
        std::int64_t arrival_count = 0;                        ///< eta
        std::int64_t emitted_count = 0;                        ///< mu
        std::array<std::int64_t, kBandCount> intensity_sum{};  ///< I-hat, see to_fixed()
        std::int64_t length_sum = 0;                           ///< r-hat, in 2^-20 m
        std::array<std::int64_t, 3> direction_sum{};  ///< energy of all bands times direction
        std::int64_t inserted_frame = 0;
        std::uint64_t image = 0;  ///< see Arrival
    };

    /// `window_frames` >= 1 is F, the lifetime of an entry or the length of the window. What does
    /// not fit in `memory_bytes` is forgotten, oldest first.
    DiffusePathCache(Readout readout, int window_frames, std::size_t memory_bytes);
    ~DiffusePathCache();
    DiffusePathCache(DiffusePathCache&&) noexcept;
    DiffusePathCache& operator=(DiffusePathCache&&) noexcept;

    /// Another bound for the memory, from the next frame on.
    void set_memory_bytes(std::size_t memory_bytes);

    /// One frame: expires what is too old, takes the frame's arrivals and ages every entry by the
    /// number of rays that the source emitted in this frame.
    void add_frame(std::span<const Arrival> arrivals, int rays);

    /// Adds every entry that no image source counts as a delayed impulse to a response.
    void add_to(const SpecularSound& images, EnergyResponse& response) const;

    std::size_t size() const;
    std::size_t memory_bytes() const;
    const Entry* find(const PathIdentifier& path) const;

    /// Energies in fixed point, 2^-32 1/m2.
    static std::int64_t to_fixed(float energy);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace aula
