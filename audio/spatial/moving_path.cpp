#include "audio/spatial/moving_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "audio/dsp/kernels.h"
#include "audio/spatial/head_shelf.h"

namespace aula {

namespace {

// Re the speed of sound. A faster change is a jump.
constexpr double kFastestMove = 0.5;

// The ear filters are updated if the direction has turned by more than this, radians.
constexpr float kSameDirection = 1e-4F;
// Or if the distance has changed by this share: 0.05 dB.
constexpr float kSameDistance = 3e-3F;

/// `v` scaled to a distinctness. The midpoint of opposite directions has none: vectors shorter than
/// half the distinctness are doubled, which is continuous.
std::array<float, 3> with_distinctness(const std::array<float, 3>& v, float distinctness) noexcept {
    const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0.5F * distinctness)) return {2 * v[0], 2 * v[1], 2 * v[2]};
    return {v[0] / length * distinctness, v[1] / length * distinctness,
            v[2] / length * distinctness};
}

float distance(const std::array<float, 3>& a, const std::array<float, 3>& b) noexcept {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Moves the last `past` samples to the front, as the filter's history for the next block.
void keep_history(AlignedVector<float>& signal, std::size_t past, std::size_t samples) noexcept {
    std::copy_n(signal.begin() + static_cast<std::ptrdiff_t>(samples), past, signal.begin());
}

}  // namespace

Glide::Glide(std::size_t samples)
    : samples_(samples), follow_(1 - std::exp(-4 / static_cast<double>(samples))) {}

void Glide::jump(double value) noexcept {
    target_ = line_ = value_ = value;
    remaining_ = 0;
}

void Glide::move_to(double target, std::size_t samples) noexcept {
    target_ = target;
    remaining_ = samples;
    slope_ = (target - line_) / static_cast<double>(samples);
}

PathTrack::PathTrack(const PathShape& shape)
    : shape_(shape),
      ear_taps_(shape.hrtf != nullptr ? shape.hrtf->taps() : 1),
      delay_(shape.frame_samples),
      points_(shape.points()),
      ear_fade_(shape.turn_samples),
      last_filter_(shape.filter_taps),
      filtered_(shape.block),
      faded_(shape.block) {
    for (Point& point : points_) {
        point.ear_delay = Glide(shape.turn_samples);
        point.delayed.resize(shape.filter_taps - 1 + shape.block);
        point.ear_input.resize(ear_taps_ - 1 + shape.block);
        for (AlignedVector<float>& ear : point.ear) ear.resize(ear_taps_);
    }
}

/// Whether a source is nearer than those of the measured head, so that its distance is heard.
bool PathTrack::is_near(float distance_m) const noexcept {
    return distance_m > 0 && distance_m < shape_.hrtf->distance_m();
}

/// Whether a direction in head axes, or the distance, has left that of the newest ear filters.
bool PathTrack::ears_differ(const std::array<float, 3>& direction) const noexcept {
    if (!(distance(direction, ear_direction_) <= kSameDirection)) return true;
    return (is_near(distance_m_) || is_near(ear_distance_m_)) &&
           std::abs(distance_m_ - ear_distance_m_) > kSameDistance * ear_distance_m_;
}

/// Sets ear filters and delays for a direction in head axes and the present distance.
void PathTrack::set_ears(const std::array<float, 3>& direction, std::size_t slot) noexcept {
    ear_direction_ = direction;
    ear_distance_m_ = distance_m_;
    shape_.hrtf->ears(direction, {points_[0].ear[slot], points_[1].ear[slot]}, ear_delays_);
    for (double& delay : ear_delays_) delay *= shape_.sample_rate_hz;
    if (!is_near(distance_m_)) return;
    // The ears are at the ends of the y axis. At the centre of the head they are equal.
    const HeardDirection heard = heard_direction(direction);
    for (std::size_t ear = 0; ear < 2; ++ear) {
        const float cosine = ear == 0 ? heard.unit[1] : -heard.unit[1];
        HeadShelf shelf = HeadShelf::at(distance_m_, shape_.hrtf->distance_m(), cosine);
        shelf.low_db *= heard.distinctness;
        shelf.high_db *= heard.distinctness;
        shelf.apply(shape_.sample_rate_hz, points_[ear].ear[slot]);
    }
}

void PathTrack::start(const PathSound& sound, const DelayLine& line,
                      const HeadRotation& head) noexcept {
    delay_.jump(sound.delay_samples);
    direction_ = target_ = sound.direction;
    distance_m_ = target_m_ = sound.distance_m;
    remaining_ = 0;
    moved_samples_ = move_samples_;
    if (shape_.hrtf != nullptr) {
        ear_fade_ = shape_.turn_samples;
        set_ears(in_head_axes(head, direction_), 0);
    } else {
        encoding_ = encode_direction(direction_);
    }
    const std::size_t past = shape_.filter_taps - 1;
    for (std::size_t p = 0; p < points_.size(); ++p) {
        Point& point = points_[p];
        point.ear_delay.jump(ear_delays_[p]);
        std::fill(point.ear_input.begin(), point.ear_input.end(), 0.0F);
        std::fill(point.delayed.begin(), point.delayed.end(), 0.0F);
        for (std::size_t n = past - (sound.taps - 1); n < past; ++n) {
            const auto offset = static_cast<std::ptrdiff_t>(n) - static_cast<std::ptrdiff_t>(past);
            point.delayed[n] = line.read(offset, sound.delay_samples + ear_delays_[p]);
        }
    }
}

void PathTrack::move(const PathSound& from, const PathSound& to, std::size_t samples) noexcept {
    delay_.move_to(to.delay_samples, samples);
    target_ = to.direction;
    target_m_ = to.distance_m;
    remaining_ = samples;
    const float rest = 1 - static_cast<float>(moved_samples_) / static_cast<float>(move_samples_);
    for (std::size_t i = 0; i < from.taps; ++i)
        last_filter_[i] = from.filter[i] + rest * (last_filter_[i] - from.filter[i]);
    for (std::size_t i = from.taps; i < last_taps_; ++i) last_filter_[i] *= rest;
    last_taps_ = rest > 0 ? std::max(from.taps, last_taps_) : from.taps;
    move_samples_ = samples;
    // At rest one filter suffices.
    const bool is_equal =
        last_taps_ == to.taps &&
        std::equal(to.filter.begin(), to.filter.begin() + static_cast<std::ptrdiff_t>(to.taps),
                   last_filter_.begin());
    moved_samples_ = is_equal ? samples : 0;
}

bool PathTrack::can_reach(const PathSound& sound) const noexcept {
    return std::abs(sound.delay_samples - delay_.target()) <=
           kFastestMove * static_cast<double>(shape_.frame_samples);
}

void PathTrack::advance_direction(std::size_t samples) noexcept {
    if (remaining_ == 0) return;
    if (samples >= remaining_) {
        direction_ = target_;
        distance_m_ = target_m_;
        remaining_ = 0;
        return;
    }
    const float share = static_cast<float>(samples) / static_cast<float>(remaining_);
    const float from = heard_direction(direction_).distinctness;
    const float to = heard_direction(target_).distinctness;
    for (std::size_t i = 0; i < 3; ++i) direction_[i] += share * (target_[i] - direction_[i]);
    direction_ = with_distinctness(direction_, from + share * (to - from));
    distance_m_ += share * (target_m_ - distance_m_);
    remaining_ -= samples;
}

void PathTrack::read(const DelayLine& line, const HeadRotation& head,
                     std::size_t samples) noexcept {
    advance_direction(samples);
    if (shape_.hrtf != nullptr && ear_fade_ == shape_.turn_samples) {
        const std::array<float, 3> direction = in_head_axes(head, direction_);
        if (ears_differ(direction)) {
            set_ears(direction, 1);
            ear_fade_ = 0;
            for (std::size_t p = 0; p < 2; ++p) points_[p].ear_delay.move_to(ear_delays_[p]);
        }
    }
    const std::size_t past = shape_.filter_taps - 1;
    for (std::size_t n = 0; n < samples; ++n) {
        const double delay = delay_.next();
        for (Point& point : points_) {
            point.delayed[past + n] =
                line.read(static_cast<std::ptrdiff_t>(n), delay + point.ear_delay.next());
        }
    }
    for (Point& point : points_) std::fill_n(point.ear_input.data() + ear_taps_ - 1, samples, 0.0F);
}

void PathTrack::add(const PathSound& sound, std::span<const float> weights,
                    std::size_t samples) noexcept {
    const std::size_t past = shape_.filter_taps - 1;
    const bool moves = moved_samples_ < move_samples_;
    const float step = 1 / static_cast<float>(move_samples_);
    for (Point& point : points_) {
        filter(point.delayed.data() + past, sound.filter.data(), sound.taps, filtered_.data(),
               samples);
        if (moves) {
            filter(point.delayed.data() + past, last_filter_.data(), last_taps_, faded_.data(),
                   samples);
            for (std::size_t n = 0; n < samples; ++n) {
                const std::size_t moved = std::min(moved_samples_ + n, move_samples_);
                const float share = step * static_cast<float>(moved);
                filtered_[n] = faded_[n] + share * (filtered_[n] - faded_[n]);
            }
        }
        float* const ear_input = point.ear_input.data() + ear_taps_ - 1;
        if (weights.empty()) {
            for (std::size_t n = 0; n < samples; ++n) ear_input[n] += filtered_[n];
        } else {
            for (std::size_t n = 0; n < samples; ++n) ear_input[n] += weights[n] * filtered_[n];
        }
    }
}

void PathTrack::add_ear(Point& point, float* output, std::size_t samples) noexcept {
    const float* const ear_input = point.ear_input.data() + ear_taps_ - 1;
    filter(ear_input, point.ear[0].data(), ear_taps_, filtered_.data(), samples);
    if (ear_fade_ < shape_.turn_samples) {
        filter(ear_input, point.ear[1].data(), ear_taps_, faded_.data(), samples);
        const float step = 1 / static_cast<float>(shape_.turn_samples);
        for (std::size_t n = 0; n < samples; ++n) {
            const float share = std::min(1.0F, step * static_cast<float>(ear_fade_ + n + 1));
            filtered_[n] += share * (faded_[n] - filtered_[n]);
        }
    }
    for (std::size_t n = 0; n < samples; ++n) output[n] += filtered_[n];
}

void PathTrack::add_field(std::span<float* const> outputs, std::size_t samples) noexcept {
    const auto target = encode_direction(direction_);
    const float* const ear_input = points_[0].ear_input.data();
    const float step = 1 / static_cast<float>(samples);
    for (std::size_t o = 0; o < outputs.size(); ++o) {
        const float slope = step * (target[o] - encoding_[o]);
        for (std::size_t n = 0; n < samples; ++n) {
            outputs[o][n] += (encoding_[o] + slope * static_cast<float>(n + 1)) * ear_input[n];
        }
    }
    encoding_ = target;
}

void PathTrack::finish(std::span<float* const> outputs, std::size_t samples) noexcept {
    if (shape_.hrtf != nullptr) {
        for (std::size_t p = 0; p < 2; ++p) add_ear(points_[p], outputs[p], samples);
        if (ear_fade_ < shape_.turn_samples) {
            ear_fade_ = std::min(ear_fade_ + samples, shape_.turn_samples);
            if (ear_fade_ == shape_.turn_samples) {
                for (Point& point : points_) std::swap(point.ear[0], point.ear[1]);
            }
        }
    } else {
        add_field(outputs, samples);
    }
    moved_samples_ = std::min(moved_samples_ + samples, move_samples_);
    for (Point& point : points_) {
        keep_history(point.delayed, shape_.filter_taps - 1, samples);
        keep_history(point.ear_input, ear_taps_ - 1, samples);
    }
}

MovingPath::MovingPath(const PathShape& shape, const Fade& fade)
    : fade_(fade), tracks_{PathTrack(shape), PathTrack(shape)}, weights_(shape.block) {}

void MovingPath::exchange(const PathSound* sound, const DelayLine& line, const HeadRotation& head,
                          std::size_t samples) noexcept {
    assert(sound != nullptr && !fading());
    const bool same = current_.audible() && sound->present && current_.sound->id == sound->id;
    if (same && tracks_[current_.track].can_reach(*sound)) {
        tracks_[current_.track].move(*current_.sound, *sound, samples);
        current_.sound = sound;
        return;
    }
    Voice& voice = current_.sound == nullptr ? current_ : next_;
    voice.sound = sound;
    fade_.start();
    if (!sound->present) return;
    voice.track = 1 - current_.track;
    tracks_[voice.track].start(*sound, line, head);
}

void MovingPath::process(const DelayLine& line, const HeadRotation& head,
                         std::span<float* const> outputs, std::size_t samples) noexcept {
    const bool current_audible = current_.audible();
    const bool next_audible = next_.audible();
    if (!current_audible && !next_audible) return advance_fade(samples);
    std::array<bool, 2> active{};
    if (current_audible) active[current_.track] = true;
    if (next_audible) active[next_.track] = true;
    for (std::size_t t = 0; t < 2; ++t) {
        if (active[t]) tracks_[t].read(line, head, samples);
    }
    if (!fading()) {
        if (current_audible) tracks_[current_.track].add(*current_.sound, {}, samples);
    } else {
        const std::span<float> weights(weights_.data(), samples);
        for (std::size_t n = 0; n < samples; ++n) weights[n] = fade_.weight(n);
        if (next_audible) tracks_[next_.track].add(*next_.sound, weights, samples);
        for (float& weight : weights) weight = 1 - weight;
        if (current_audible) tracks_[current_.track].add(*current_.sound, weights, samples);
    }
    for (std::size_t t = 0; t < 2; ++t) {
        if (active[t]) tracks_[t].finish(outputs, samples);
    }
    advance_fade(samples);
}

void MovingPath::advance_fade(std::size_t samples) noexcept {
    if (!fading()) return;
    fade_.advance(samples);
    if (!fade_.done()) return;
    current_ = next_;
    next_.sound = nullptr;
}

}  // namespace aula
