#pragma once

#include <array>
#include <vector>

#include "aula/engine/energy_response.h"

namespace aula {

/// Moves bins [first_bin, end_bin) of a response by a share of the way to an estimate of the same
/// bins. From a share of 1 on they are the estimate's.
void approach(const EnergyResponse& estimate, std::size_t first_bin, std::size_t end_bin,
              float share, EnergyResponse& response);

/// The level of a response, followed by three alpha-beta filters of different gains. The change is
/// their mean, weighted by how well each has predicted the newest levels (multiple-model
/// estimation, Magill 1965). Of equally good ones the slowest counts most: it has the least noise.
class LevelFilters {
 public:
    /// Takes the level of an estimate over that of the response, less one, and returns the factor
    /// by which the response is to change.
    float follow(float error);

 private:
    /// Choices: the first one averages fifty frames, the last one follows a door in two.
    static constexpr std::array<float, 3> kGains{0.02F, 0.2F, 0.5F};
    /// Choices: a faster filter counts as much as the first one if it makes the errors 10 times, or
    /// 100 times, as likely.
    static constexpr std::array<float, 3> kPriors{1, 0.1F, 0.01F};

    struct Filter {
        float level = 0;          ///< over that of the response, less one
        float slope = 0;          ///< per frame
        float squared_error = 0;  ///< of its predictions, smoothed
    };
    std::array<Filter, kGains.size()> filters_;
    int frames_ = 0;  ///< at most those over which errors are averaged
};

/// The response of a pair from one noisy and unbiased estimate in each frame.
///
/// Adaptive-response-rate exponential smoothing (Trigg & Leach 1967), in groups of bins: the share
/// of the new estimate follows from the tracking signal, the smoothed error over the smoothed
/// absolute error of the group's energy. Errors of one sign are a change, after which the newest
/// estimate counts almost alone; errors of both signs are noise, which is averaged. The smoothed
/// error is also the lag of the smoothed response, which is added as far as it exceeds the noise.
/// While the ends move, the level that all groups have in common is followed by LevelFilters.
/// The early bins, which change within centimetres, are those of the newest estimate. [propagation
/// thread]
class ResponseFollower {
 public:
    /// The least share of a frame is 1 / N, N = min(`window_frames`, kMostFrames), so that at most
    /// about 2 N - 1 frames count. `window_frames` >= 1.
    ResponseFollower(const EnergyResponse& silent, int window_frames);

    /// Drops all estimates.
    void restart() { frames_ = 0; }

    /// Takes the estimate of a frame, the mean of the last `frames` >= 1 frames, in which ends and
    /// scene have moved by `moved_m` >= 0 together. A mean of N frames, or of all frames since the
    /// restart, is the response.
    void follow(const EnergyResponse& estimate, int frames, double moved_m);

    /// Energies and directions; without paths.
    const EnergyResponse& response() const { return response_; }

    /// A choice: half a second at 30 frames per second. The error of walks falls with the root of
    /// the frames, and their lag grows with them.
    static constexpr int kMostFrames = 16;

 private:
    /// Consecutive bins of equal width.
    struct Group {
        std::size_t first_bin = 0;
        std::size_t end_bin = 0;
        float width_m = 0;         ///< of a bin
        bool silent = true;        ///< the smoothed response holds nothing
        float newest_error = 0;    ///< relative
        float error = 0;           ///< smoothed
        float absolute_error = 0;  ///< the same
    };
    static float reliability(const Group& group);
    void follow_level();
    static float lag(const Group& group, float share);
    static void compare(const EnergyResponse& estimate, const EnergyResponse& response,
                        Group& group);

    int most_frames_;  ///< N
    int frames_ = 0;   ///< since the restart
    std::vector<Group> groups_;
    LevelFilters level_;  ///< of all groups, while the ends move
    EnergyResponse smoothed_;
    EnergyResponse response_;  ///< without the lag of smoothed_
};

}  // namespace aula
