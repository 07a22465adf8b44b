#include "apps/room/auralizer/exact_playback.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/room/frames/ray_budget.h"
#include "audio/spatial/ambisonics.h"

namespace aula {

namespace {

constexpr int kBlock = 256;

/// Frames computed ahead, so that fast frames compensate for slow ones; one if the filters of a
/// frame are large.
constexpr std::size_t kFramesAhead = 2;
constexpr std::size_t kLargeFrame_bytes = std::size_t{64} << 20;

std::size_t frames_ahead(const RendererConfig& config, std::size_t listeners) {
    // Spectra have twice as many numbers as responses.
    const std::size_t channels = ambisonic_channels(field_order(config));
    const std::size_t frame_bytes =
        2 * sizeof(float) * config.response_samples * channels * config.sources * listeners;
    return frame_bytes > kLargeFrame_bytes ? 1 : kFramesAhead;
}

/// Counted time of a frame; none if the number of rays is given.
std::optional<double> work_of(const Simulation& simulation) {
    if (simulation.rays) return {};
    return allowed_s(simulation.quality, 1 / double{simulation.frame_rate_hz});
}

}  // namespace

ExactPlayback::ExactPlayback(const Scene& scene, const AuralizerOptions& options,
                             std::shared_ptr<const Hrtf> hrtf)
    : RoomPlayback(scene, options, kBlock, std::move(hrtf)),
      frame_rate_hz_(static_cast<double>(scene.simulation.frame_rate_hz)),
      unit_(options.sample_by_sample ? 1 : kBlock),
      work_s_(work_of(scene.simulation)),
      frames_ahead_(frames_ahead(computer_.config(), options.listeners)),
      block_outputs_(options.listeners * channel_count(options.output), std::vector<float>(kBlock)),
      block_pointers_(block_outputs_.size()),
      used_frames_(options.listeners) {}

void ExactPlayback::commit(std::int64_t until) {
    {
        const std::lock_guard lock(mutex_);
        committed_ = std::max(committed_, until);
    }
    changed_.notify_all();
}

int ExactPlayback::latency_samples() const { return unit_ == kBlock ? kBlock : 0; }

ChangeTime ExactPlayback::time_of(std::int64_t at) const {
    if (in_before_frame()) return {std::max(at, *frame_sample_), true};
    return {std::max(at, committed_), false};
}

void ExactPlayback::begin_source(SourceId source, const ChangeTime& time) {
    renderer_changes_.add(time, [this, source](RoomRenderer& renderer) {
        renderer.set_source(renderer_slots_.begin(source), source);
    });
}

void ExactPlayback::end_source(SourceId source, const ChangeTime& time) {
    renderer_changes_.add(time, [this, source](RoomRenderer& renderer) {
        renderer.set_source(renderer_slots_.end(source), {});
    });
}

void ExactPlayback::turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) {
    renderer_changes_.add(
        time, [listener, pose](RoomRenderer& renderer) { renderer.turn_head(listener, pose); });
}

/// The first sample at or after a frame's time.
std::int64_t ExactPlayback::frame_start(std::int64_t frame) const {
    return static_cast<std::int64_t>(
        std::ceil(static_cast<double>(frame) * rate_hz_ / frame_rate_hz_));
}

void ExactPlayback::compute_frames(Auralizer& auralizer) {
    for (std::int64_t k = 0;; ++k) {
        const std::int64_t sample = frame_start(k);
        ListenerFrames frames(used_frames_.size());
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] {
                return stop_ || (committed_ > sample && ready_.size() < frames_ahead_);
            });
            if (stop_) return;
            for (std::size_t l = 0; l < frames.size(); ++l) {
                if (used_frames_[l].empty()) continue;
                frames[l] = std::move(used_frames_[l].back());
                used_frames_[l].pop_back();
            }
        }
        const double time_s = static_cast<double>(k) / frame_rate_hz_;
        call_before_frame(auralizer, sample, time_s);
        FrameRoom room = take_changes(sample, sample, time_s);
        room.state.exchange = {sample, frame_start(k + 1)};
        if (!room.state.rays) room.state.work_s = work_s_;
        computer_.compute(room, frames);
        {
            const std::lock_guard lock(mutex_);
            ready_.push_back({std::move(frames), newest_tail_samples()});
        }
        changed_.notify_all();
    }
}

/// Blocks begin at multiples of their size, independent of the size of the calls. Without latency
/// they end with the call.
void ExactPlayback::render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                           int samples) {
    if (broken_) std::rethrow_exception(broken_);
    const FlushDenormals flush;
    for (int done = 0; done < samples;) {
        const int left = std::min(kBlock - filled_, samples - done);
        const int part = pause_.until_silence(pause_.advance(outputs, done, left));
        if (part == 0) {
            done += left;
            continue;
        }
        const std::span<const float> weights = pause_.weights(part);
        // Of several signals of a source the first counts.
        for (std::size_t i = inputs.size(); i-- > 0;) {
            const SourceSignal& input = inputs[i];
            if (input.samples == nullptr) continue;
            BlockInput& block = block_inputs_[input.source.number];
            block.samples.resize(kBlock);
            block.given = true;
            std::copy_n(input.samples + done, part, block.samples.data() + filled_);
            apply_weights(weights, block.samples.data() + filled_);
        }
        const int first = filled_;
        const bool delayed = latency_samples() > 0;
        const auto write_outputs = [&] {
            for (std::size_t c = 0; c < outputs.size(); ++c) {
                std::copy_n(block_outputs_[c].data() + first, part, outputs[c] + done);
                apply_weights(weights, outputs[c] + done);
            }
        };
        if (delayed) write_outputs();
        filled_ += part;
        commit(rendered_ += part);
        if (filled_ == kBlock || !delayed) {
            try {
                render_block();
            } catch (...) {
                broken_ = std::current_exception();
                throw;
            }
        }
        if (!delayed) write_outputs();
        done += part;
    }
}

/// Gives the next frame to the renderer; waits for it.
void ExactPlayback::take_frames() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return failure_ || !ready_.empty(); });
    if (ready_.empty()) std::rethrow_exception(failure_);
    auto [frames, tail_samples] = std::move(ready_.front());
    ready_.pop_front();
    tail_samples_ = tail_samples;
    for (std::size_t l = 0; l < frames.size(); ++l) {
        Mailbox<RenderFrame>& mailbox = renderer_.frames(l);
        mailbox.publish(std::move(frames[l]));
        while (auto back = mailbox.reclaim()) used_frames_[l].push_back(std::move(back));
    }
    lock.unlock();
    changed_.notify_all();
    ++next_frame_;
}

/// Renders the block of the present signals, divided where frames and changes begin.
void ExactPlayback::render_block() {
    const std::int64_t end = rendered_.load();
    const std::int64_t begin = end - filled_;
    block_signals_.clear();
    for (const auto& [number, input] : block_inputs_)
        block_signals_.push_back({{number}, input.samples.data()});
    for (std::int64_t first = begin; first < end;) {
        if (frame_start(next_frame_) <= first) take_frames();
        std::int64_t part_end = std::min(end, frame_start(next_frame_));
        {
            const std::lock_guard lock(mutex_);
            renderer_changes_.apply(first, renderer_);
            part_end = std::min(part_end, renderer_changes_.next());
        }
        for (; first < part_end; first += unit_) {
            const auto offset = static_cast<int>(first - begin);
            for (std::size_t c = 0; c < block_pointers_.size(); ++c)
                block_pointers_[c] = block_outputs_[c].data() + offset;
            renderer_.render(block_signals_, offset, {}, block_pointers_,
                             static_cast<int>(std::min<std::int64_t>(unit_, part_end - first)));
        }
        first = part_end;
    }
    std::erase_if(block_inputs_, [](const auto& entry) { return !entry.second.given; });
    for (auto& [number, input] : block_inputs_) {
        std::fill(input.samples.begin(), input.samples.end(), 0.0F);
        input.given = false;
    }
    filled_ = 0;
}

}  // namespace aula
