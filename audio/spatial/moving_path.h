#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/base/realtime.h"
#include "audio/dsp/delay_line.h"
#include "audio/dsp/fade.h"
#include "audio/spatial/ambisonics.h"
#include "audio/spatial/hrtf.h"

namespace aula {

/// One discrete path of a source, direct sound or an early reflection, as it is in one frame.
struct PathSound {
    bool present = false;                     ///< otherwise silent, and the rest is meaningless
    std::uint64_t id = 0;                     ///< the same for the same path in every frame
    double delay_samples = 0;                 ///< to the middle of the head
    std::array<float, 3> direction{1, 0, 0};  ///< unit, world axes, where it comes from
    AlignedVector<float> filter;              ///< distance, air and walls
};

/// A value that follows its target in a straight line over a set time; one pole rounds the corners,
/// for a corner in a delay is a step in pitch. [audio thread, wait-free]
class Glide {
 public:
    explicit Glide(std::size_t samples = 1);

    void jump(double value) noexcept AULA_NONBLOCKING;
    void move_to(double target) noexcept AULA_NONBLOCKING;
    double target() const noexcept AULA_NONBLOCKING { return target_; }

    double next() noexcept AULA_NONBLOCKING {
        if (remaining_ > 0) {
            --remaining_;
            line_ = remaining_ == 0 ? target_ : line_ + slope_;
        }
        value_ += follow_ * (line_ - value_);
        return value_;
    }

 private:
    std::size_t samples_;
    double follow_;
    std::size_t remaining_ = 0;
    double target_ = 0;
    double line_ = 0;
    double slope_ = 0;
    double value_ = 0;
};

/// What the moving paths of a renderer share.
struct PathShape {
    /// Heard by the two ears of this head, each with a delay of its own; null: encoded into an
    /// ambisonic field of `order` in world axes.
    const Hrtf* hrtf = nullptr;
    int order = 0;
    double sample_rate_hz = 48000;
    std::size_t filter_taps = 256;
    std::size_t block = 256;
    std::size_t frame_samples = 1600;  ///< a path moves to its next place evenly in this time
    std::size_t turn_samples = 256;    ///< the head's turning is crossfaded over this

    std::size_t points() const { return hrtf != nullptr ? 2 : 1; }
    std::size_t outputs() const { return hrtf != nullptr ? 2 : ambisonic_channels(order); }
};

/// A place that moves along a delay line, heard by the ears or encoded into a field.
/// [audio thread, but for the constructor]
class PathTrack {
 public:
    explicit PathTrack(const PathShape& shape);

    /// Is at once where the path is, with nothing heard before.
    void start(const PathSound& sound, const DelayLine& line,
               const HeadRotation& head) noexcept AULA_NONBLOCKING;

    /// Moves on to where the path is in the next frame.
    void move_to(const PathSound& sound) noexcept AULA_NONBLOCKING;

    /// Whether a source could move there within a frame.
    bool can_reach(const PathSound& sound) const noexcept AULA_NONBLOCKING;

    /// Reads the block in hand; the head is where it is at its end.
    void read(const DelayLine& line, const HeadRotation& head,
              std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Adds what was read, through a filter of the path, to what is heard.
    /// `weights`: of every sample, or empty.
    void add(const PathSound& sound, std::span<const float> weights,
             std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Adds what is heard to the outputs and is done with the block.
    void finish(std::span<float* const> outputs, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    struct Point {
        Glide ear_delay;
        AlignedVector<float> delayed;  ///< filter_taps - 1 of before, then the block in hand
        AlignedVector<float> heard;    ///< taps of the ear - 1 of before, then the block in hand
        std::array<AlignedVector<float>, 2> ear;  ///< filter in use, filter being faded to
    };

    void take_ears(const std::array<float, 3>& direction,
                   std::size_t place) noexcept AULA_NONBLOCKING;
    void advance_direction(std::size_t samples) noexcept AULA_NONBLOCKING;
    void add_ear(Point& point, float* output, std::size_t samples) noexcept AULA_NONBLOCKING;
    void add_field(std::span<float* const> outputs, std::size_t samples) noexcept AULA_NONBLOCKING;

    PathShape shape_;
    std::size_t ear_taps_;
    Glide delay_;
    std::vector<Point> points_;
    std::array<double, 2> ear_delays_{};

    std::array<float, 3> direction_{};  ///< world axes
    std::array<float, 3> target_{};
    std::size_t remaining_ = 0;             ///< samples until the direction is there
    std::array<float, 3> ear_direction_{};  ///< head axes, that the newest ear filters are for
    std::size_t turned_ = 0;                ///< samples of the crossfade of ears that are done
    std::array<float, kMostAmbisonicChannels> encoding_{};

    AlignedVector<float> filtered_;
    AlignedVector<float> faded_;
};

/// A discrete path of one source through the delay line of its dry sound. Its delay and direction
/// glide from frame to frame, so that moving gives the Doppler shift; the ears follow the head from
/// block to block; filters are crossfaded. What is another path, or would have to move at more than
/// half the speed of sound, is crossfaded to instead. [audio thread, but for the constructor]
class MovingPath {
 public:
    /// `fade`: from frame to frame.
    MovingPath(const PathShape& shape, const Fade& fade);

    /// Moves on to `sound`, which must live until the next exchange is over; the first at once.
    /// Not to be called while fading().
    void exchange(const PathSound* sound, const DelayLine& line,
                  const HeadRotation& head) noexcept AULA_NONBLOCKING;
    bool fading() const noexcept AULA_NONBLOCKING { return next_.sound != nullptr; }

    /// Adds to the outputs: two ears, or the channels of a field. At most a block of samples.
    void process(const DelayLine& line, const HeadRotation& head, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    /// A frame being heard through one of the two tracks.
    struct Voice {
        const PathSound* sound = nullptr;
        std::size_t track = 0;

        bool heard() const noexcept AULA_NONBLOCKING { return sound != nullptr && sound->present; }
    };

    Fade fade_;
    std::array<PathTrack, 2> tracks_;
    Voice current_;
    Voice next_;
    AlignedVector<float> weights_;
};

}  // namespace aula
