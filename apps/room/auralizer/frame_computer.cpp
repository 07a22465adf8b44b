#include "apps/room/auralizer/frame_computer.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "apps/room/frames/ray_budget.h"

namespace aula {

FrameComputer::FrameComputer(const Scene& scene, const FrameSettings& settings,
                             std::shared_ptr<const Hrtf> hrtf)
    : hrtf_(std::move(hrtf)),
      maker_(std::in_place, scene, settings, hrtf_),
      config_(maker_->config()),
      response_length_s_(maker_->response_length_s()),
      patch_size_m_(maker_->patch_size_m()) {
    status_.frame_period_ms = 1000 * config().frame_s;
    status_.response_length_s = response_length_s();
}

void FrameComputer::compute(const FrameRoom& room, ListenerFrames& frames) {
    using Clock = std::chrono::steady_clock;
    for (auto& frame : frames)
        if (!frame) frame = maker_->make_frame();
    const auto begin = Clock::now();
    std::vector<SourcePairs> pairs;
    std::size_t silent_pairs = 0;
    {
        const std::lock_guard computing(maker_mutex_);
        for (const auto& [object, material] : room.materials)
            maker_->set_object_material(object, material);
        maker_->fill(room.state, frames);
        for (const SourceState& source : room.state.sources) {
            if (source.removed_at) continue;
            SourcePairs of_source{{source.id}, {}};
            for (std::size_t l = 0; l < frames.size(); ++l) {
                PairState& pair = of_source.at.emplace_back();
                pair.visible = maker_->visible(source.id, l);
                if (!maker_->reaches(source.id, l)) {
                    const PairState* const before = find_pair({source.id}, l);
                    pair.silent_frames = before != nullptr ? before->silent_frames + 1 : 1;
                }
                if (is_silent(pair)) ++silent_pairs;
            }
            pairs.push_back(std::move(of_source));
        }
    }
    const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    const std::lock_guard lock(mutex_);
    std::swap(pairs_, pairs);
    status_.silent_pairs = silent_pairs;
    frame_sum_ms_ += took_ms;
    ++status_.frames;
    if (took_ms > status_.frame_period_ms) ++status_.late_frames;
    status_.frame_ms = took_ms;
    status_.frame_mean_ms = frame_sum_ms_ / static_cast<double>(status_.frames);
    counted_sum_ms_ += 1000 * counted_s(maker_->statistics());
    status_.counted_mean_ms = counted_sum_ms_ / static_cast<double>(status_.frames);
    status_.frame_worst_ms = std::max(status_.frame_worst_ms, took_ms);
    status_.rays = maker_->rays();
    status_.memory_bytes = maker_->statistics().memory_bytes;
}

void FrameComputer::continue_counts(const FrameComputer& before) {
    const std::scoped_lock lock(mutex_, before.mutex_);
    const double period_ms = status_.frame_period_ms;
    status_ = before.status_;
    status_.frame_period_ms = period_ms;
    status_.response_length_s = response_length_s_;
    frame_sum_ms_ = before.frame_sum_ms_;
    counted_sum_ms_ = before.counted_sum_ms_;
    pairs_ = before.pairs_;
    handed_over_ = before.handed_over_;
}

void FrameComputer::end() {
    const std::lock_guard computing(maker_mutex_);
    maker_.reset();
}

void FrameComputer::set_handed_over() {
    const std::lock_guard lock(mutex_);
    handed_over_ = std::chrono::steady_clock::now();
}

void FrameComputer::count_skipped_frames(std::uint64_t frames) {
    const std::lock_guard lock(mutex_);
    status_.skipped_frames += frames;
}

std::vector<std::vector<float>> FrameComputer::impulse_response(SourceId source,
                                                                std::size_t listener) const {
    Pose head;
    std::optional<HeardSound> heard;
    {
        const std::lock_guard computing(maker_mutex_);
        if (maker_) heard = maker_->sound(source.number, listener);
        if (!heard) return {};
        head = maker_->listener(listener);
    }
    return ResponseRenderer(config(), response_length_s(), hrtf_).response(heard->sound, head);
}

bool FrameComputer::visible(SourceId source, std::size_t listener) const {
    const std::lock_guard lock(mutex_);
    const PairState* const pair = find_pair(source, listener);
    return pair != nullptr && pair->visible;
}

bool FrameComputer::silent(SourceId source, std::size_t listener) const {
    const std::lock_guard lock(mutex_);
    const PairState* const pair = find_pair(source, listener);
    return pair != nullptr && is_silent(*pair);
}

/// The state of a pair in the newest frame; null if there is none. On the propagation thread, or
/// with the mutex locked.
const FrameComputer::PairState* FrameComputer::find_pair(SourceId source,
                                                         std::size_t listener) const {
    for (const SourcePairs& pairs : pairs_)
        if (pairs.source == source)
            return listener < pairs.at.size() ? &pairs.at[listener] : nullptr;
    return nullptr;
}

AuralizerStatus FrameComputer::status() const {
    const std::lock_guard lock(mutex_);
    AuralizerStatus status = status_;
    if (handed_over_)
        status.frame_age_s =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - *handed_over_).count();
    return status;
}

}  // namespace aula
