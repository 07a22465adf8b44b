#include "apps/session/live_mixer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace aula {

namespace {

/// Seconds of sound that a slow reader may be behind.
constexpr double kHeard_s = 2;

constexpr double kPauseFade_s = 0.02;

int frame_samples(const RendererConfig& config) {
    return static_cast<int>(std::lround(config.frame_s * config.sample_rate_hz));
}

/// Rising half of a raised cosine, 0 at the start and 1 one sample after the end.
std::vector<float> rising(std::size_t samples) {
    std::vector<float> weights(samples);
    for (std::size_t i = 0; i < samples; ++i) {
        const double phase =
            std::numbers::pi * static_cast<double>(i) / static_cast<double>(samples);
        weights[i] = static_cast<float>(0.5 - 0.5 * std::cos(phase));
    }
    return weights;
}

float largest(std::span<float* const> channels, int samples) noexcept {
    float largest = 0;
    for (const float* channel : channels)
        for (int i = 0; i < samples; ++i) largest = std::max(largest, std::abs(channel[i]));
    return largest;
}

}  // namespace

Stage::Stage(const RendererConfig& config, SignalSet signals, const Timeline& timeline,
             std::shared_ptr<const Hrtf> hrtf, bool starts_anew)
    : rate_hz_(config.sample_rate_hz),
      timeline_(timeline),
      starts_anew_(starts_anew),
      first_signals_(std::make_unique<SignalSet>(std::move(signals))),
      signals_(first_signals_.get()),
      renderer_(config, std::move(hrtf)),
      head_(frame_samples(config)),
      fade_(rising(static_cast<std::size_t>(std::lround(kChangeFade_s * rate_hz_)))),
      output_fade_(fade_.size()),
      signal_fade_(fade_.size()),
      ring_samples_(static_cast<std::int64_t>(config.response_samples) +
                    std::llround(2 * kChangeFade_s * rate_hz_)),
      inputs_(config.sources, std::vector<float>(static_cast<std::size_t>(config.block))),
      outputs_(channel_count(config.output),
               std::vector<float>(static_cast<std::size_t>(config.block))),
      scratch_(static_cast<std::size_t>(config.block)) {
    for (const auto& input : inputs_) input_pointers_.push_back(input.data());
    for (auto& output : outputs_) output_pointers_.push_back(output.data());
}

Stage::~Stage() {
    for (SignalSet* signals : {signals_, fading_signals_})
        if (signals != nullptr && signals != first_signals_.get()) next_signals_.give_back(signals);
}

/// `before`: what plays until then, if anything does.
void Stage::begin(std::int64_t position, const Stage* before) noexcept {
    zero_ = starts_anew_ ? position : before != nullptr ? before->zero_ : 0;
    input_fade_ = before != nullptr ? 0 : fade_.size();
}

/// The signals, changed, ended by the timeline and faded as far as the stage is.
void Stage::read_inputs(std::int64_t position, int samples) noexcept {
    const auto count = static_cast<std::size_t>(samples);
    const std::int64_t first = position - zero_;
    if (fading_signals_ == nullptr) {
        if (SignalSet* next = next_signals_.take()) {
            fading_signals_ = std::exchange(signals_, next);
            signal_fade_ = 0;
        }
    }
    for (std::size_t s = 0; s < inputs_.size(); ++s) {
        const std::span<float> input(inputs_[s].data(), count);
        (*signals_)[s]->read(first, position, input);
        if (fading_signals_ != nullptr) {
            const std::span<float> old(scratch_.data(), count);
            (*fading_signals_)[s]->read(first, position, old);
            for (std::size_t i = 0; i < count; ++i) {
                const std::size_t at = signal_fade_ + i;
                const float weight = at < fade_.size() ? fade_[at] : 1.0F;
                input[i] = old[i] + weight * (input[i] - old[i]);
            }
        }
        timeline_.fade(first, rate_hz_, input);
        if (state_ == State::playing && faded_in()) continue;
        for (std::size_t i = 0; i < count; ++i) {
            if (state_ == State::playing) {
                const std::size_t at = input_fade_ + i;
                input[i] *= at < fade_.size() ? fade_[at] : 1.0F;
            } else {
                // The falling half is one minus the rising one: with what follows they add up to 1.
                const std::size_t left = input_fade_ > i ? input_fade_ - i : 0;
                input[i] *= left > 0 ? 1 - fade_[fade_.size() - left] : 0.0F;
            }
        }
    }
    if (fading_signals_ != nullptr) {
        signal_fade_ += count;
        if (signal_fade_ >= fade_.size()) {
            if (fading_signals_ != first_signals_.get()) next_signals_.give_back(fading_signals_);
            fading_signals_ = nullptr;
        }
    }
    if (state_ == State::playing)
        input_fade_ = std::min(fade_.size(), input_fade_ + count);
    else
        input_fade_ -= std::min(input_fade_, count);
}

/// Adds the stage's sound to the sum.
void Stage::render(std::int64_t position, std::span<float* const> sum, int samples) noexcept {
    read_inputs(position, samples);
    renderer_.render(input_pointers_, head_.advance(samples), output_pointers_, samples);
    if (state_ == State::ringing) {
        ring_samples_ -= samples;
        if (ring_samples_ <= 0) end();
    }
    const bool ending = state_ == State::ending;
    for (std::size_t c = 0; c < sum.size(); ++c) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(samples); ++i) {
            float weight = 1;
            if (ending) {
                const std::size_t left = output_fade_ > i ? output_fade_ - i : 0;
                weight = left > 0 ? 1 - fade_[fade_.size() - left] : 0.0F;
            }
            sum[c][i] += weight * outputs_[c][i];
        }
    }
    if (ending) output_fade_ -= std::min(output_fade_, static_cast<std::size_t>(samples));
}

LiveMixer::LiveMixer(double sample_rate_hz, int block, std::size_t channels)
    : rate_hz_(sample_rate_hz),
      block_(block),
      channels_(channels),
      limiter_(sample_rate_hz, channels, block),
      output_pointers_(channels),
      interleaved_(static_cast<std::size_t>(block) * channels),
      heard_(static_cast<std::size_t>(kHeard_s * sample_rate_hz) * channels),
      pause_fade_(rising(static_cast<std::size_t>(std::lround(kPauseFade_s * rate_hz_)))),
      audible_(pause_fade_.size()) {}

LiveMixer::~LiveMixer() {
    if (playing_ != nullptr) stages_.give_back(playing_);
    if (waiting_ != nullptr) stages_.give_back(waiting_);
    for (Stage* stage : ringing_)
        if (stage != nullptr) stages_.give_back(stage);
}

void LiveMixer::render(std::span<float* const> outputs, int samples) noexcept {
    for (int done = 0; done < samples; done += block_) {
        for (std::size_t c = 0; c < channels_; ++c) output_pointers_[c] = outputs[c] + done;
        render_block(output_pointers_, std::min(block_, samples - done));
    }
}

void LiveMixer::follow_head(std::int64_t now_ns) noexcept {
    HeadPose* pose = head_poses_.take();
    if (pose == nullptr) return;
    head_ = pose->pose;
    head_latency_.add(now_ns - pose->given_ns);
    head_known_ = true;
    head_poses_.give_back(pose);
    if (playing_ != nullptr) playing_->head_.turn_to(head_);
    for (Stage* stage : ringing_)
        if (stage != nullptr) stage->head_.turn_to(head_);
}

/// Lets the next stage begin where there is one: when the one that plays is fully there, and fewer
/// than the most ring out. Otherwise it waits, and the oldest of those that ring is ended.
void LiveMixer::change_stage() noexcept {
    if (waiting_ == nullptr) waiting_ = stages_.take();
    if (waiting_ == nullptr) return;
    if (playing_ != nullptr) {
        if (!playing_->faded_in()) return;
        if (ringing_.back() != nullptr) {
            ringing_.front()->end();
            return;
        }
        playing_->retire();
        *std::find(ringing_.begin(), ringing_.end(), nullptr) = playing_;
    }
    // The first one begins from silence, whatever its signals begin with.
    if (playing_ == nullptr) audible_ = 0;
    waiting_->begin(position_.load(std::memory_order_relaxed), playing_);
    playing_ = std::exchange(waiting_, nullptr);
    if (head_known_) playing_->head_.turn_to(head_);
}

void LiveMixer::give_back_ended() noexcept {
    for (Stage*& stage : ringing_) {
        if (stage == nullptr || !stage->ended()) continue;
        stages_.give_back(std::exchange(stage, nullptr));
    }
    // The oldest first, no gaps.
    if (ringing_.front() == nullptr) std::swap(ringing_.front(), ringing_.back());
}

/// Goes along the fade of a pause, up or down.
void LiveMixer::fade_pause(std::span<float* const> outputs, int samples) noexcept {
    const bool down = paused_.load(std::memory_order_relaxed);
    const std::size_t top = pause_fade_.size();
    for (std::size_t i = 0; i < static_cast<std::size_t>(samples); ++i) {
        if (down && audible_ > 0) --audible_;
        if (!down && audible_ < top) ++audible_;
        if (audible_ == top) continue;
        for (float* channel : outputs) channel[i] *= pause_fade_[audible_];
    }
    silent_.store(audible_ == 0, std::memory_order_relaxed);
}

void LiveMixer::render_block(std::span<float* const> outputs, int samples) noexcept {
    if (audible_ == 0 && paused_.load(std::memory_order_relaxed)) {
        for (float* channel : outputs) std::fill_n(channel, samples, 0.0F);
        silent_.store(true, std::memory_order_relaxed);
        return;
    }
    const std::int64_t now_ns = clock_ns();
    follow_head(now_ns);
    change_stage();
    const std::int64_t position = position_.load(std::memory_order_relaxed);
    for (float* channel : outputs) std::fill_n(channel, samples, 0.0F);
    for (Stage* stage : ringing_)
        if (stage != nullptr) stage->render(position, outputs, samples);
    if (playing_ != nullptr) playing_->render(position, outputs, samples);
    if (playing_ != nullptr) {
        // A frame stamped 0 is not to be counted.
        const std::int64_t stamp = playing_->renderer_.newest_stamp();
        if (stamp != newest_stamp_ && stamp != 0) frame_latency_.add(now_ns - stamp);
        newest_stamp_ = stamp;
    }
    give_back_ended();

    limiter_.process(outputs, samples);
    fade_pause(outputs, samples);
    const float peak = std::max(largest(outputs, samples), peak_.load(std::memory_order_relaxed));
    peak_.store(peak, std::memory_order_relaxed);
    const float gain =
        std::min(limiter_.least_gain(), limiter_gain_.load(std::memory_order_relaxed));
    limiter_gain_.store(gain, std::memory_order_relaxed);
    if (listened_.load(std::memory_order_relaxed)) {
        const std::size_t count = static_cast<std::size_t>(samples) * channels_;
        for (std::size_t i = 0; i < count; ++i)
            interleaved_[i] = outputs[i % channels_][i / channels_];
        heard_.write(std::span(interleaved_).first(count));
    }
    position_.store(position + samples, std::memory_order_relaxed);
}

}  // namespace aula
