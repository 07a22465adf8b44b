#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "engine/response/energy_response.h"
#include "engine/response/room_acoustics.h"

namespace aula {

/// All octaves together, where a band is asked for.
inline constexpr std::size_t kAllBands = kBandCount;

/// Energy in dB, and what stands for nothing.
inline constexpr float kNothing_db = -200;
float energy_db(double energy);

/// The energy of a band, or of all.
double band_energy(const Bands& bands, std::size_t band);

/// A discrete arrival as a plot shows it.
struct Arrow {
    double time_s = 0;
    float level_db = 0;
    int order = 0;  ///< 0 is the direct sound
};

/// The energy response of a band in steps of equal length: what is binned in dB per step, and the
/// discrete arrivals.
struct EnergyCurve {
    double step_s = 0;
    std::vector<float> diffuse_db;
    std::vector<Arrow> arrows;
};
EnergyCurve energy_curve(const EnergyResponse& response, std::size_t band, double step_s);

/// Schroeder's backward integral in dB below the whole: [step].
std::vector<float> decay_curve_db(const EnergyResponse& response, std::size_t band, double step_s);

/// How much what is published differs from frame to frame while nothing moves: in windows of 20 ms
/// the standard deviation over the mean, root mean square over the windows, weighted by their
/// energy. What converges has less of it from frame to frame than from start to start.
class FrameNoise {
 public:
    /// Forgets the frames before if anything has moved or changed since.
    void add(const EnergyResponse& response, const Vec3& source, const Vec3& listener,
             std::uint64_t change);

    /// Relative, of one band or the mean of all; empty before enough frames.
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
