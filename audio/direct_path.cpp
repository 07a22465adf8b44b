#include "audio/direct_path.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace aula {

namespace {

// Of the speed of sound: faster is no movement but a jump.
constexpr double kFastestMove = 0.5;

}  // namespace

Glide::Glide(std::size_t samples)
    : samples_(samples), follow_(1 - std::exp(-4 / static_cast<double>(samples))) {}

void Glide::jump(double value) noexcept {
    target_ = line_ = value_ = value;
    remaining_ = 0;
}

void Glide::move_to(double target) noexcept {
    target_ = target;
    remaining_ = samples_;
    slope_ = (target - line_) / static_cast<double>(samples_);
}

DirectPath::DirectPath(const Shape& shape, const FractionalDelay& interpolator,
                       std::span<const float> fade)
    : shape_(shape),
      interpolator_(interpolator),
      fade_(fade),
      // A reader that starts reads back as far as its filter hears.
      length_(std::bit_ceil(shape.longest_delay_samples + shape.filter_taps + shape.block +
                            2 * kInterpolationTaps)),
      ring_(length_ + kInterpolationTaps),
      filtered_(shape.block) {
    assert(shape.points == 1 || shape.outputs == shape.points);
    for (auto& set : readers_) {
        for (std::size_t p = 0; p < shape.points; ++p) {
            set[p].delay = Glide(shape.frame_samples);
            set[p].delayed.resize(shape.filter_taps - 1 + shape.block);
        }
    }
}

void DirectPath::exchange(const DirectSound* sound) noexcept {
    assert(sound != nullptr && !fading());
    Voice& voice = current_.sound == nullptr ? current_ : next_;
    voice.sound = sound;
    fade_position_ = 0;
    if (!sound->present) return;
    const bool moving = &voice == &next_ && current_.sound->present;
    if (moving && near_enough(*sound, current_.readers)) {
        voice.readers = current_.readers;
        for (std::size_t p = 0; p < shape_.points; ++p) {
            readers_[voice.readers][p].delay.move_to(sound->points[p].delay_samples);
        }
    } else {
        voice.readers = 1 - current_.readers;
        start_readers(voice);
    }
}

bool DirectPath::near_enough(const DirectSound& target, std::size_t readers) const noexcept {
    const double fastest = kFastestMove * static_cast<double>(shape_.frame_samples);
    for (std::size_t p = 0; p < shape_.points; ++p) {
        const double before = readers_[readers][p].delay.target();
        if (std::abs(target.points[p].delay_samples - before) > fastest) return false;
    }
    return true;
}

void DirectPath::start_readers(Voice& voice) noexcept {
    const std::size_t past = shape_.filter_taps - 1;
    for (std::size_t p = 0; p < shape_.points; ++p) {
        Reader& reader = readers_[voice.readers][p];
        const double delay = voice.sound->points[p].delay_samples;
        reader.delay.jump(delay);
        for (std::size_t n = 0; n < past; ++n) {
            reader.delayed[n] = read(time_ + length_ + n - past, delay);
        }
    }
}

void DirectPath::process(const float* input, std::span<float* const> outputs,
                         std::size_t samples) noexcept {
    assert(outputs.size() == shape_.outputs && samples <= shape_.block);
    write(input, samples);
    const bool current_heard = current_.sound != nullptr && current_.sound->present;
    const bool next_heard = next_.sound != nullptr && next_.sound->present;

    std::array<bool, 2> heard{};
    if (current_heard) heard[current_.readers] = true;
    if (next_heard) heard[next_.readers] = true;
    for (std::size_t set = 0; set < 2; ++set) {
        if (!heard[set]) continue;
        for (std::size_t p = 0; p < shape_.points; ++p) advance(readers_[set][p], samples);
    }

    const auto add = [&](const Voice& voice, bool fading_in) {
        for (std::size_t p = 0; p < shape_.points; ++p) {
            const DirectSound::Point& point = voice.sound->points[p];
            filter(readers_[voice.readers][p].delayed.data() + shape_.filter_taps - 1,
                   point.filter.data(), shape_.filter_taps, filtered_.data(), samples);
            if (fading()) {
                for (std::size_t n = 0; n < samples; ++n) {
                    const std::size_t position = fade_position_ + n;
                    const float in = position < fade_.size() ? fade_[position] : 1.0F;
                    filtered_[n] *= fading_in ? in : 1 - in;
                }
            }
            if (shape_.points > 1) {
                for (std::size_t n = 0; n < samples; ++n) outputs[p][n] += filtered_[n];
                continue;
            }
            for (std::size_t o = 0; o < shape_.outputs; ++o) {
                const float gain = voice.sound->encoding[o];
                for (std::size_t n = 0; n < samples; ++n) outputs[o][n] += gain * filtered_[n];
            }
        }
    };
    if (current_heard) add(current_, false);
    if (next_heard) add(next_, true);

    for (std::size_t set = 0; set < 2; ++set) {
        if (!heard[set]) continue;
        for (std::size_t p = 0; p < shape_.points; ++p) {
            AlignedVector<float>& delayed = readers_[set][p].delayed;
            const auto last = delayed.begin() + static_cast<std::ptrdiff_t>(samples);
            std::copy_n(last, shape_.filter_taps - 1, delayed.begin());
        }
    }
    time_ += samples;
    if (!fading()) return;
    fade_position_ += samples;
    if (fade_position_ < fade_.size()) return;
    current_ = next_;
    next_.sound = nullptr;
}

void DirectPath::write(const float* input, std::size_t samples) noexcept {
    for (std::size_t n = 0; n < samples; ++n) {
        const std::size_t place = (time_ + n) & (length_ - 1);
        ring_[place] = input[n];
        if (place < kInterpolationTaps) ring_[length_ + place] = input[n];
    }
}

float DirectPath::read(std::size_t time, double delay_samples) const noexcept {
    const double whole = std::ceil(delay_samples);
    const double fraction = whole - delay_samples;
    const std::size_t first =
        time + length_ - static_cast<std::size_t>(whole) - FractionalDelay::kBefore;
    return interpolator_.read(ring_.data() + (first & (length_ - 1)), fraction);
}

/// Reads the block in hand, behind what was read before.
void DirectPath::advance(Reader& reader, std::size_t samples) noexcept {
    const std::size_t past = shape_.filter_taps - 1;
    for (std::size_t n = 0; n < samples; ++n) {
        reader.delayed[past + n] = read(time_ + n, reader.delay.next());
    }
}

}  // namespace aula
