#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "audio/aligned.h"
#include "audio/fractional_delay.h"
#include "audio/realtime.h"

namespace aula {

/// What the direct path of one source is in one frame: where the delay line is read (one point, or
/// one for each ear) and the filter behind it.
struct DirectSound {
    static constexpr std::size_t kMaxPoints = 2;

    struct Point {
        double delay_samples = 0;
        AlignedVector<float> filter;
    };

    bool present = false;  ///< otherwise silent, and the rest is meaningless
    std::array<Point, kMaxPoints> points;
    std::array<float, 4> encoding{1, 0, 0, 0};  ///< of a single point into the outputs
};

/// A value that follows its target in a straight line over a set time; one pole rounds the corners,
/// for a corner in a delay is a step in pitch. [audio thread, wait-free]
class Glide {
 public:
    explicit Glide(std::size_t samples = 1);

    void jump(double value) noexcept AULA_NONBLOCKING;
    void move_to(double target) noexcept AULA_NONBLOCKING;
    double target() const noexcept { return target_; }

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

/// The direct path of one source through a delay line of its dry sound. Delays glide from frame to
/// frame, so that moving gives the Doppler shift; filters and encoding are crossfaded; a delay that
/// would have to move at more than half the speed of sound is crossfaded from the old place to the
/// new one instead. [audio thread, but for the constructor]
class DirectPath {
 public:
    struct Shape {
        std::size_t points = 1;  ///< two points go to two outputs, one is encoded into all outputs
        std::size_t outputs = 1;
        std::size_t filter_taps = 256;
        std::size_t block = 256;
        std::size_t frame_samples = 1600;
        std::size_t longest_delay_samples = 48000;
    };

    /// `interpolator` and `fade` (weights of the next frame from an exchange on) outlive this.
    DirectPath(const Shape& shape, const FractionalDelay& interpolator,
               std::span<const float> fade);

    /// The shortest delay that a reader which needs samples from both sides can give.
    static constexpr double kShortestDelay_samples = FractionalDelay::kAfter;

    /// Moves on to `sound`, which must live until the next exchange is over; the first at once.
    /// Not to be called while fading().
    void exchange(const DirectSound* sound) noexcept AULA_NONBLOCKING;
    bool fading() const noexcept AULA_NONBLOCKING { return next_.sound != nullptr; }

    /// Adds to the outputs. At most a block of samples.
    void process(const float* input, std::span<float* const> outputs,
                 std::size_t samples) noexcept AULA_NONBLOCKING;

 private:
    /// A moving place in the delay line, with what was read there.
    struct Reader {
        Glide delay;
        AlignedVector<float> delayed;  ///< filter_taps - 1 of before, then the block in hand
    };
    /// A frame being heard through one of the two sets of readers.
    struct Voice {
        const DirectSound* sound = nullptr;
        std::size_t readers = 0;
    };

    void start_readers(Voice& voice) noexcept AULA_NONBLOCKING;
    void write(const float* input, std::size_t samples) noexcept AULA_NONBLOCKING;
    float read(std::size_t time, double delay_samples) const noexcept AULA_NONBLOCKING;
    void advance(Reader& reader, std::size_t samples) noexcept AULA_NONBLOCKING;
    bool near_enough(const DirectSound& target,
                     std::size_t readers) const noexcept AULA_NONBLOCKING;

    Shape shape_;
    const FractionalDelay& interpolator_;
    std::span<const float> fade_;
    std::size_t fade_position_ = 0;

    std::size_t length_;         ///< of the ring, a power of two
    AlignedVector<float> ring_;  ///< its first samples once more at the end, to be read in one run
    std::size_t time_ = 0;       ///< of the next sample to be written

    std::array<std::array<Reader, DirectSound::kMaxPoints>, 2> readers_;
    Voice current_;
    Voice next_;
    AlignedVector<float> filtered_;
};

}  // namespace aula
