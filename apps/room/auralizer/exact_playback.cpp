#include "apps/room/auralizer/exact_playback.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "apps/room/frames/ray_budget.h"
#include "audio/spatial/ambisonics.h"

namespace aula {

namespace {

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

ExactPlayback::ExactPlayback(std::shared_ptr<BuiltRoom> first, const AuralizerOptions& options)
    : RoomPlayback(std::move(first), options, kBlock),
      unit_(options.sample_by_sample ? 1 : kBlock),
      block_outputs_(options.listeners * channel_count(options.output), std::vector<float>(kBlock)),
      block_pointers_(block_outputs_.size()),
      used_frames_(options.listeners),
      used_by_(&newest()) {
    exchange_.advance_now(false);
}

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
    renderer_changes_.add(time, [source](RoomExchange<SoundingRoom>& rooms) {
        SoundingRoom& room = *rooms.playing();
        room.renderer.set_source(room.slots.begin(source), source);
    });
}

void ExactPlayback::end_source(SourceId source, const ChangeTime& time) {
    renderer_changes_.add(time, [source](RoomExchange<SoundingRoom>& rooms) {
        rooms.for_each([source](SoundingRoom& room) {
            if (room.plays(source)) room.renderer.set_source(room.slots.end(source), {});
        });
    });
}

void ExactPlayback::turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) {
    renderer_changes_.add(time, [listener, pose](RoomExchange<SoundingRoom>& rooms) {
        rooms.for_each([&](SoundingRoom& room) { room.renderer.turn_head(listener, pose); });
    });
}

std::int64_t ExactPlayback::FrameTimes::sample(std::int64_t frame) const {
    return begin + static_cast<std::int64_t>(
                       std::ceil(static_cast<double>(frame) * sample_rate_hz / frame_rate_hz));
}

double ExactPlayback::FrameTimes::time_s(std::int64_t frame) const {
    return static_cast<double>(begin) / sample_rate_hz + static_cast<double>(frame) / frame_rate_hz;
}

ExactPlayback::FrameTimes ExactPlayback::times_of(const BuiltRoom& room, std::int64_t begin) const {
    return {rate_hz_, static_cast<double>(room.scene->simulation.frame_rate_hz), begin};
}

void ExactPlayback::compute_frames(Auralizer& auralizer) {
    FrameTimes times = times_of(*built(), 0);
    for (std::int64_t k = 0;; ++k) {
        const std::int64_t sample = times.sample(k);
        const std::size_t ahead = frames_ahead(computer().config(), listeners_);
        ListenerFrames frames(listeners_);
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock,
                          [&] { return stop_ || (committed_ > sample && ready_.size() < ahead); });
            if (stop_) return;
            for (std::size_t l = 0; l < listeners_; ++l) {
                if (used_frames_[l].empty()) continue;
                frames[l] = std::move(used_frames_[l].back());
                used_frames_[l].pop_back();
            }
        }
        const double time_s = times.time_s(k);
        call_before_frame(auralizer, sample, time_s);
        FrameRoom room = *take_changes(sample, sample, time_s);
        if (scene_begins()) {
            times = times_of(*built(), sample);
            k = 0;
            frames = ListenerFrames(listeners_);  // the others have the size of the scene before
        }
        const std::int64_t end = times.sample(k + 1);
        room.state.exchange = {sample - times.begin, end - times.begin};
        if (!room.state.rays) room.state.work_s = work_of(built()->scene->simulation);
        computer().compute(room, frames);
        if (scene_begins()) finish_beginning();
        {
            const std::lock_guard lock(mutex_);
            ready_.push_back(
                {std::move(frames), newest_tail_samples(), end, std::move(built()->made)});
        }
        changed_.notify_all();
    }
}

void ExactPlayback::take_scene(SoundingRoom& next) {
    for (auto& frames : used_frames_) frames.clear();
    used_by_ = &next;
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

/// Gives the frames of a sample to the renderers; waits for them.
void ExactPlayback::take_frames(std::int64_t sample) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return failure_ || !ready_.empty(); });
    if (ready_.empty()) std::rethrow_exception(failure_);
    Ready ready = std::move(ready_.front());
    ready_.pop_front();
    tail_samples_ = ready.tail_samples;
    next_frame_ = ready.end;
    if (ready.next_room) {
        // The scene begins with what these changes have made.
        renderer_changes_.apply(sample, exchange_);
        rooms_.publish(std::move(ready.next_room));
        exchange_.advance_now(sample > 0);
    }
    SoundingRoom& room = *exchange_.playing();
    room.tail = ready.tail_samples;
    for (std::size_t l = 0; l < listeners_; ++l) {
        Mailbox<RenderFrame>& mailbox = room.renderer.frames(l);
        mailbox.publish(std::move(ready.frames[l]));
        while (auto back = mailbox.reclaim())
            if (&room == used_by_) used_frames_[l].push_back(std::move(back));
    }
    while (rooms_.reclaim()) {
    }
    lock.unlock();
    changed_.notify_all();
}

/// Renders the block of the present signals, divided where frames and changes begin.
void ExactPlayback::render_block() {
    const std::int64_t end = rendered_.load();
    const std::int64_t begin = end - filled_;
    block_signals_.clear();
    for (const auto& [number, input] : block_inputs_)
        block_signals_.push_back({{number}, input.samples.data()});
    for (std::int64_t first = begin; first < end;) {
        if (next_frame_ <= first) take_frames(first);
        std::int64_t part_end = std::min(end, next_frame_);
        {
            const std::lock_guard lock(mutex_);
            renderer_changes_.apply(first, exchange_);
            part_end = std::min(part_end, renderer_changes_.next());
        }
        for (; first < part_end; first += unit_) {
            const auto offset = static_cast<int>(first - begin);
            for (std::size_t c = 0; c < block_pointers_.size(); ++c)
                block_pointers_[c] = block_outputs_[c].data() + offset;
            render_rooms(block_signals_, offset, {}, block_pointers_,
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
