#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"
#include "engine/base/wave_masks.h"
#include "engine/waves/room_waves.h"

namespace aula {

/// A transform of responses that may outlast it: the spectra are those of the response times
/// exp(-decay t), so that what wraps around to the beginning is 30 dB weaker.
struct WaveTransform {
    /// Twice as long as a response: half of it takes what filters spread before the beginning.
    WaveTransform(double length_s, double rate_hz);

    /// The frequency of the first bin above 0.
    double step_hz() const { return rate_hz / static_cast<double>(size); }

    /// exp(decay t) at a sample, the last quarter of which is before the beginning.
    float growth(std::size_t sample) const;

    std::size_t size;
    double rate_hz;
    double decay_per_s;
};

/// The field of a pair below the crossover in the bins of energy responses.
struct WaveEnergy {
    Bands rays = Bands::filled(1);               ///< share of the energy of the rays that remains
    std::vector<Bands> energy;                   ///< [bin] as EnergyResponse::energy
    std::vector<DirectionMoments> directions{};  ///< [bin]

    /// Joins the field to the response of rays.
    void join(EnergyResponse& response) const;
};

/// The amplitude of a path at a frequency, linear in its logarithm between the centres of octaves.
double path_amplitude(const SoundPath& path, double hz);

/// The field of a source at a receiver below the crossover. The reverberation of a source with a
/// directivity is that of one without, of the same power.
class PairWaves {
 public:
    /// `direct`: the path by which the receiver sees the source, a part of the field; or none.
    PairWaves(WaveResponse response, std::optional<SoundPath> direct, const WaveMasks& masks,
              double speed_of_sound_m_s)
        : response_(std::move(response)),
          direct_(std::move(direct)),
          masks_(masks),
          speed_of_sound_m_s_(speed_of_sound_m_s) {}

    /// The direct sound that the receiver sees.
    const std::optional<SoundPath>& direct() const { return direct_; }
    const WaveMasks& masks() const { return masks_; }

    /// True if the rays have several times the energy of the modes.
    bool is_outweighed(const EnergyResponse& rays) const;

    /// With the direct sound.
    WaveEnergy energy(const TimeBins& bins) const;

    /// The pressure, and the pressures of plane waves that have its velocities along x, y and z, at
    /// the first `count` frequencies of a transform, without the direct sound.
    WaveSpectra field(const WaveTransform& transform, std::size_t count) const;

 private:
    WaveResponse response_;
    std::optional<SoundPath> direct_;
    WaveMasks masks_;
    double speed_of_sound_m_s_;
};

/// The modes of the rooms of a scene's sources, at the time 0.
class WaveJoin {
 public:
    /// With Simulation::waves_hz above 0. See RoomWaves::find().
    explicit WaveJoin(const Scene& scene, const WaveJoin* before = nullptr,
                      const std::stop_token& stop = {});

    /// Which sources have no modes, and why.
    const std::vector<std::string>& warnings() const { return warnings_; }

    /// The rooms with modes; no air connects them.
    std::span<const RoomWaves> rooms() const { return rooms_; }

    /// Where the modes of a room and rays are joined.
    static WaveMasks masks(const RoomWaves& room);

    /// The room with modes that a place is in; null: none.
    const RoomWaves* room_at(const Vec3& place) const;

    /// The field of a pair whose rays have a response; empty without modes, if one of both is
    /// outside the room, or if walls pass more sound than the air between them.
    std::optional<PairWaves> pair(const Vec3& source, const Vec3& receiver,
                                  const EnergyResponse& rays) const;

 private:
    void find(const Scene& scene, const WaveJoin* before, const std::stop_token& stop);

    std::vector<RoomWaves> rooms_;
    double speed_of_sound_m_s_;
    std::vector<std::string> warnings_;
};

/// What a measurement with modes keeps for impulse responses.
struct JoinedWaves {
    std::vector<std::optional<PairWaves>> pairs;  ///< [pair]
    std::vector<EnergyResponse> rays;             ///< [pair] without the modes
};

}  // namespace aula
