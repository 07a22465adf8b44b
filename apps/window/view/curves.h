#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "apps/room/frames/frame_view.h"
#include "aula/engine/energy_response.h"
#include "aula/engine/room_acoustics.h"
#include "aula/measurement.h"

namespace aula {

/// Band index of the sum of all octave bands.
inline constexpr std::size_t kAllBands = kBandCount;

/// Level of an energy of zero.
inline constexpr float kSilence_db = -200;
/// 10 log10 of an energy; kSilence_db below 1e-20.
float energy_db(double energy);

/// Energy of a band, or of all bands for kAllBands.
double band_energy(const Bands& bands, std::size_t band);

/// A discrete arrival: direct sound or image source.
struct DiscreteArrival {
    double time_s = 0;
    float level_db = 0;
    int order = 0;  ///< reflection order; 0 is the direct sound
};

/// The energy response of a band: the binned part in dB per step of `step_s`, and the discrete
/// arrivals.
struct EnergyCurve {
    double step_s = 0;
    std::vector<float> diffuse_db;
    std::vector<DiscreteArrival> arrivals;
};
EnergyCurve energy_curve(const EnergyResponse& response, std::size_t band, double step_s);

/// The parameters of a view's response, as of a measured one.
PairParameters view_parameters(const FrameView& view, const SpeechConditions& speech);

/// Schroeder's backward integral in dB relative to the total energy: [step].
std::vector<float> decay_curve_db(const EnergyResponse& response, std::size_t band, double step_s);

/// Frame-to-frame noise of the energy response while nothing moves: the relative standard deviation
/// in windows of 20 ms, as root mean square weighted by the windows' energies. Converging
/// estimators vary less between frames than between restarts.
class FrameNoise {
 public:
    /// Adds a frame. Discards earlier frames if a position or the change number differs.
    void add(const EnergyResponse& response, const Vec3& source, const Vec3& listener,
             std::uint64_t change);

    /// Relative standard deviation of a band, or of the sum of all; empty before kFewest frames.
    std::optional<double> relative(std::size_t band) const;

 private:
    static constexpr std::size_t kFrames = 24;
    static constexpr std::size_t kFewest = 5;

    Vec3 source_{0};
    Vec3 listener_{0};
    std::uint64_t change_ = 0;
    std::vector<std::vector<Bands>> frames_;  ///< [frame][window], the oldest replaced first
    std::size_t next_ = 0;
};

}  // namespace aula
