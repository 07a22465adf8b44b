#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "aula/engine/energy_response.h"
#include "aula/engine/scene.h"
#include "engine/waves/room_waves.h"

namespace aula {

/// The amplitudes with which modes and rays are joined: an octave wide, linear in phase, with
/// squares that add up to 1, so that independent sounds keep their power.
struct WaveMasks {
    double crossover_hz = 0;  ///< where both have equal power

    /// Of the modes.
    double low(double hz) const;
    /// Of the rays.
    double high(double hz) const;
    /// Where low() ends.
    double end_hz() const;
};

/// The field of a pair below the crossover in the bins of energy responses.
struct WaveEnergy {
    Bands rays = Bands::filled(1);  ///< share of the energy of the rays that remains
    std::vector<Bands> energy;      ///< [bin] as EnergyResponse::energy
    std::vector<Vec3> intensity;    ///< [bin]

    /// Joins the field to the response of rays.
    void join(EnergyResponse& response) const;
};

/// The field of a source at a receiver below the crossover.
class PairWaves {
 public:
    /// `has_direct`: the receiver sees the source, and the direct sound is part of the field.
    PairWaves(WaveResponse response, bool has_direct, const WaveMasks& masks,
              double speed_of_sound_m_s)
        : response_(std::move(response)),
          has_direct_(has_direct),
          masks_(masks),
          speed_of_sound_m_s_(speed_of_sound_m_s) {}

    bool has_direct() const { return has_direct_; }

    /// With the direct sound.
    WaveEnergy energy(const TimeBins& bins) const;

    /// The impulse responses of W, Y, Z and X (ACN, SN3D, world axes) without the direct sound that
    /// the receiver sees.
    std::array<std::vector<float>, 4> impulse_response(double sample_rate_hz,
                                                       std::size_t samples) const;

 private:
    WaveField field(double hz, bool with_direct) const;

    WaveResponse response_;
    bool has_direct_;
    WaveMasks masks_;
    double speed_of_sound_m_s_;
};

/// A signal filtered by WaveMasks::high.
void keep_high(const WaveMasks& masks, double sample_rate_hz, std::vector<float>& signal);

/// The direct sound with the high-pass filter of the modes, below 20 Hz, so that both interfere as
/// they would without it.
void cut_subsonic(double sample_rate_hz, std::vector<float>& signal);

/// The modes of a scene's room for a measurement.
class WaveJoin {
 public:
    /// Of the rooms of the sources, with Simulation::waves_hz above 0.
    explicit WaveJoin(const Scene& scene);

    /// Which sources have no modes, and why.
    const std::vector<std::string>& warnings() const { return warnings_; }
    const WaveMasks& masks() const { return masks_; }

    /// The field of a pair whose rays have a response; empty without modes, or if one of both is
    /// outside the room.
    std::optional<PairWaves> pair(const Source& source, const Vec3& receiver,
                                  const EnergyResponse& rays) const;

 private:
    void find(const Scene& scene, std::vector<const Source*> sources);

    std::optional<RoomWaves> waves_;
    WaveMasks masks_;
    double speed_of_sound_m_s_;
    std::vector<std::string> warnings_;
};

/// What a measurement with modes keeps for impulse responses.
struct JoinedWaves {
    WaveMasks masks;
    std::vector<std::optional<PairWaves>> pairs;  ///< [pair]
    std::vector<EnergyResponse> rays;             ///< [pair] without the modes
};

}  // namespace aula
