#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "audio/base/aligned.h"
#include "audio/dsp/delay_line.h"
#include "audio/dsp/fade.h"
#include "audio/spatial/ambisonics.h"
#include "audio/spatial/hrtf.h"
#include "aula/audio/realtime.h"

namespace aula {

/// A discrete path of a source (direct sound or an early reflection) in one frame.
struct PathSound {
    bool present = false;                     ///< false: silent, other members are ignored
    std::uint64_t id = 0;                     ///< identifies the path in all frames
    double delay_samples = 0;                 ///< to the centre of the head
    std::array<float, 3> direction{1, 0, 0};  ///< of arrival, world axes (HeardDirection)
    float distance_m = 0;                     ///< of the source or its image; 0: far
    AlignedVector<float> filter;              ///< distance, air and walls
    std::size_t taps = 0;                     ///< of `filter`, the first ones
};

/// A value that moves linearly to its target over `samples`. A one-pole filter of that time smooths
/// the corners: a corner in a delay is a step in pitch. [audio thread, wait-free]
class Glide {
 public:
    explicit Glide(std::size_t samples = 1);

    void jump(double value) noexcept AULA_NONBLOCKING;
    void move_to(double target) noexcept AULA_NONBLOCKING { move_to(target, samples_); }

    /// Moves to the target over another time, > 0.
    void move_to(double target, std::size_t samples) noexcept AULA_NONBLOCKING;
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

/// Parameters common to the moving paths of a renderer.
struct PathShape {
    /// Renders to two ears with separate delays; null: encodes into an ambisonic field of `order`
    /// in world axes.
    const Hrtf* hrtf = nullptr;
    int order = 0;
    double sample_rate_hz = 48000;
    std::size_t filter_taps = 1024;  ///< of the longest filter
    std::size_t block = 256;
    std::size_t frame_samples = 1600;  ///< time from frame to frame
    std::size_t turn_samples = 256;    ///< a turn of the head is crossfaded over this time

    std::size_t points() const { return hrtf != nullptr ? 2 : 1; }
    std::size_t outputs() const { return hrtf != nullptr ? 2 : ambisonic_channels(order); }
};

/// A moving read position on a delay line, rendered to the ears or encoded into a field. For each
/// block: read(), add(), finish(). [audio thread, except the constructor]
class PathTrack {
 public:
    explicit PathTrack(const PathShape& shape);

    /// Jumps to the path's delay and direction and clears the history of the ears.
    void start(const PathSound& sound, const DelayLine& line,
               const HeadRotation& head) noexcept AULA_NONBLOCKING;

    /// Moves from one frame's sound of the path to that of another: delay, direction and filter,
    /// linearly over `samples`. Only the new one is used from then on.
    void move(const PathSound& from, const PathSound& to,
              std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Whether a source could move there within a frame.
    bool can_reach(const PathSound& sound) const noexcept AULA_NONBLOCKING;

    /// Reads the present block. `head` is the orientation at its end.
    void read(const DelayLine& line, const HeadRotation& head,
              std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Filters the block by the path's filter, or by what lies between that of the last frame and
    /// this one, and adds it to the input of the ears. `weights`: one per sample, or empty for
    /// ones.
    void add(const PathSound& sound, std::span<const float> weights,
             std::size_t samples) noexcept AULA_NONBLOCKING;

    /// Adds the block to the outputs and ends it.
    void finish(std::span<float* const> outputs, std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    struct Point {
        Glide ear_delay;
        AlignedVector<float> delayed;    ///< filter_taps - 1 past samples, then the present block
        AlignedVector<float> ear_input;  ///< ear_taps_ - 1 past samples, then the present block
        std::array<AlignedVector<float>, 2> ear;  ///< filter in use, filter being faded to
    };

    bool is_near(float distance_m) const noexcept AULA_NONBLOCKING;
    bool ears_differ(const std::array<float, 3>& direction) const noexcept AULA_NONBLOCKING;
    void set_ears(const std::array<float, 3>& direction,
                  std::size_t slot) noexcept AULA_NONBLOCKING;
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
    float distance_m_ = 0;
    float target_m_ = 0;
    std::size_t remaining_ = 0;             ///< samples until both reach their targets
    std::array<float, 3> ear_direction_{};  ///< direction of the newest ear filters, head axes
    float ear_distance_m_ = 0;              ///< distance of the newest ear filters
    std::size_t ear_fade_ = 0;              ///< position within the crossfade of ears, samples
    std::array<float, kMaxAmbisonicChannels> encoding_{};

    AlignedVector<float> last_filter_;  ///< from which the present one is reached
    std::size_t last_taps_ = 0;         ///< of it; the others are 0
    std::size_t move_samples_ = 1;      ///< time from the last filter to the present one
    std::size_t moved_samples_ = 1;     ///< part of it that has passed

    AlignedVector<float> filtered_;
    AlignedVector<float> faded_;
};

/// A discrete path of one source, rendered through the delay line of its dry signal. Delay and
/// direction move linearly from frame to frame, which gives the Doppler shift, and so does the
/// filter. The ears follow the head from block to block. A different path, or one that would have
/// to move faster than half the speed of sound, is crossfaded instead. [audio thread, except the
/// constructor]
class MovingPath {
 public:
    /// `fade` is that between different paths.
    MovingPath(const PathShape& shape, const Fade& fade);

    /// Moves to `sound` over `samples`, or fades to it. It must live until the next exchange has
    /// ended. The first sound takes effect immediately. Must not be called while fading().
    void exchange(const PathSound* sound, const DelayLine& line, const HeadRotation& head,
                  std::size_t samples) noexcept AULA_NONBLOCKING;
    bool fading() const noexcept AULA_NONBLOCKING { return next_.sound != nullptr; }

    /// Adds at most a block of samples to the outputs: two ears, or the channels of a field.
    void process(const DelayLine& line, const HeadRotation& head, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    void advance_fade(std::size_t samples) noexcept AULA_NONBLOCKING;

    /// A sound rendered by one of the two tracks.
    struct Voice {
        const PathSound* sound = nullptr;
        std::size_t track = 0;

        bool audible() const noexcept AULA_NONBLOCKING {
            return sound != nullptr && sound->present;
        }
    };

    Fade fade_;
    std::array<PathTrack, 2> tracks_;
    Voice current_;
    Voice next_;
    AlignedVector<float> weights_;
};

}  // namespace aula
