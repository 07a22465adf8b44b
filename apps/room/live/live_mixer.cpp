#include "apps/room/live/live_mixer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace aula {

namespace {

/// Duration of the fade between signals, as between rooms.
constexpr double kSignalFade_s = RoomExchange<SoundingRoom>::kFade_s;

/// Fade-in of a signal that begins abruptly.
constexpr double kOnsetFade_s = 0.02;

/// Duration of the output that the ring holds for its reader.
constexpr double kOutputRing_s = 2;

std::size_t to_samples(double seconds, double rate_hz) {
    return static_cast<std::size_t>(std::lround(seconds * rate_hz));
}

float largest(std::span<float* const> channels, int samples) noexcept AULA_NONBLOCKING {
    float largest = 0;
    for (const float* channel : channels)
        for (int i = 0; i < samples; ++i) largest = std::max(largest, std::abs(channel[i]));
    return largest;
}

}  // namespace

ScenePlayback::ScenePlayback(SignalSet signals, const Timeline& timeline, double sample_rate_hz,
                             int block, std::uint64_t start)
    : rate_hz_(sample_rate_hz),
      timeline_(timeline),
      start_{.number = start},
      first_signals_(std::make_unique<SignalSet>(std::move(signals))),
      signals_(first_signals_.get()),
      signal_fade_(to_samples(kSignalFade_s, rate_hz_)),
      onset_fade_(to_samples(kOnsetFade_s, rate_hz_)),
      inputs_(first_signals_->size(), std::vector<float>(static_cast<std::size_t>(block))),
      scratch_(static_cast<std::size_t>(block)) {
    for (std::size_t s = 0; s < inputs_.size(); ++s)
        source_signals_.push_back({{s + 1}, inputs_[s].data()});
}

ScenePlayback::~ScenePlayback() {
    for (SignalSet* signals : {signals_, fading_signals_})
        if (signals != nullptr && signals != first_signals_.get()) next_signals_.give_back(signals);
}

/// A scene in between with the same start may have been replaced before it sounded.
bool ScenePlayback::begin(std::int64_t sample, const RoomSignals* before) noexcept {
    const SignalStart& previous =
        before != nullptr ? static_cast<const ScenePlayback*>(before)->start_ : before_;
    start_.zero = start_.number == previous.number ? previous.zero : sample;
    if (sample != start_.zero) return true;
    onset_fade_.start();
    return false;
}

/// The signals with exchanges and the end by the timeline.
std::span<const SourceSignal> ScenePlayback::read(std::int64_t sample, int samples) noexcept {
    const auto count = static_cast<std::size_t>(samples);
    const std::int64_t first = sample - start_.zero;
    if (fading_signals_ == nullptr) {
        if (SignalSet* next = next_signals_.take()) {
            fading_signals_ = std::exchange(signals_, next);
            signal_fade_.start();
        }
    }
    for (std::size_t s = 0; s < inputs_.size(); ++s) {
        const std::span<float> input(inputs_[s].data(), count);
        (*signals_)[s]->read(first, sample, input);
        if (fading_signals_ != nullptr) {
            const std::span<float> old(scratch_.data(), count);
            (*fading_signals_)[s]->read(first, sample, old);
            signal_fade_.cross(old, input);
        }
        if (!onset_fade_.done() && (*signals_)[s]->begins_abruptly()) onset_fade_.fade_in(input);
        timeline_.fade(first, rate_hz_, input);
    }
    for (Fade* fade : {&onset_fade_, &signal_fade_}) fade->advance(count);
    if (fading_signals_ != nullptr && signal_fade_.done()) {
        if (fading_signals_ != first_signals_.get()) next_signals_.give_back(fading_signals_);
        fading_signals_ = nullptr;
    }
    return source_signals_;
}

void ScenePlayback::end(std::int64_t sample, std::span<float* const> outputs,
                        int samples) const noexcept {
    for (float* const output : outputs)
        timeline_.end(sample - start_.zero, rate_hz_, {output, static_cast<std::size_t>(samples)});
}

LiveMixer::LiveMixer(LiveAuralizer& auralizer, int block)
    : auralizer_(auralizer),
      rate_hz_(auralizer.room().sample_rate_hz()),
      block_(block),
      channels_(auralizer.room().output_channels()),
      limiter_(rate_hz_, channels_, block),
      output_pointers_(channels_),
      interleaved_(static_cast<std::size_t>(block) * channels_),
      output_ring_(static_cast<std::size_t>(kOutputRing_s * rate_hz_) * channels_),
      pause_(rate_hz_, block) {}

void LiveMixer::render(std::span<float* const> outputs, int samples) noexcept {
    const std::int64_t before_ns = std::exchange(called_ns_, clock_ns());
    if (before_ns != 0) call_interval_.add(called_ns_ - before_ns);
    for (int done = 0; done < samples;) {
        const int left = std::min(block_, samples - done);
        const int part = pause_.advance(outputs, done, left);
        for (std::size_t c = 0; c < channels_; ++c) output_pointers_[c] = outputs[c] + done;
        if (part > 0) render_block(output_pointers_, part);
        done += part > 0 ? part : left;
    }
}

/// Counts the latencies of a frame and of a head pose that the block has taken.
void LiveMixer::count_latencies(std::int64_t now_ns) noexcept {
    const auto count = [now_ns](std::int64_t pose_ns, std::int64_t& newest_ns,
                                LatencyCounts& latency) {
        if (pose_ns != newest_ns && pose_ns != 0) latency.add(now_ns - pose_ns);
        newest_ns = pose_ns;
    };
    count(auralizer_.frame_pose_ns(), frame_pose_ns_, frame_latency_);
    count(auralizer_.head_pose_ns(), head_pose_ns_, head_latency_);
}

void LiveMixer::render_block(std::span<float* const> outputs, int samples) noexcept {
    const std::int64_t now_ns = clock_ns();
    auralizer_.render({}, outputs, samples);
    count_latencies(now_ns);
    limiter_.process(outputs, samples);
    const std::span<const float> weights = pause_.weights(samples);
    for (float* const channel : outputs) apply_weights(weights, channel);
    const float peak = std::max(largest(outputs, samples), peak_.load(std::memory_order_relaxed));
    peak_.store(peak, std::memory_order_relaxed);
    const float gain = std::min(limiter_.min_gain(), limiter_gain_.load(std::memory_order_relaxed));
    limiter_gain_.store(gain, std::memory_order_relaxed);
    if (listened_.load(std::memory_order_relaxed)) {
        const auto count = static_cast<std::size_t>(samples);
        for (std::size_t c = 0; c < channels_; ++c)
            for (std::size_t i = 0; i < count; ++i) interleaved_[i * channels_ + c] = outputs[c][i];
        if (!output_ring_.write(std::span(interleaved_).first(count * channels_)))
            lost_samples_.fetch_add(samples, std::memory_order_relaxed);
    }
}

}  // namespace aula
