#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "apps/room/frames/frame_view.h"

namespace aula {

/// The level of the direct sound in each octave band over the last metres that the listener walked.
class LevelWalk {
 public:
    static constexpr double kLength_m = 10;

    struct Point {
        double walked_m = 0;                       ///< since the first view
        std::array<float, kBandCount> level_db{};  ///< 0 dB at 1 m from an omnidirectional source
    };

    /// Adds a frame. A step of less than 5 mm replaces the newest point. Another source and a jump
    /// of more than 2 m begin a new walk.
    void add(const FrameView& view);

    /// In their order, the newest last.
    const std::deque<Point>& points() const { return points_; }

    /// The point nearest to a distance walked; null before the first view.
    const Point* nearest(double walked_m) const;

 private:
    std::uint64_t frame_ = 0;
    std::size_t source_ = 0;
    Vec3 listener_{0};  ///< at the newest point
    std::deque<Point> points_;
};

/// The distance and the level of each octave band, one a line.
std::string text_of(const LevelWalk::Point& point);

}  // namespace aula
