#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "apps/room/frames/play_controls.h"
#include "apps/room/live/live_mixer.h"
#include "apps/room/live/prepared_scene.h"

namespace aula::test {

inline constexpr int kTakeBlock = 256;

/// Live playback on one thread, without a device: scenes whose first frames are computed when they
/// begin, and no others.
class LiveTake {
 public:
    /// `before`: the start of the signals that have played until `begin_s`.
    explicit LiveTake(double begin_s = 0, const SignalStart& before = {})
        : begin_s_(begin_s), before_(before) {}

    /// Prepares a scene, after those that have begun.
    std::unique_ptr<PreparedScene> prepare(const Scene& scene, const PlaybackOptions& options,
                                           bool starts_anew = false, Reusable before = {}) const {
        before.options.sample_rate_hz = options.sample_rate_hz;
        before.auralizer = auralizer_.get();
        return std::make_unique<PreparedScene>(scene, options, starts_anew, before);
    }

    /// Begins a prepared scene.
    void begin(PreparedScene& prepared, const PlayControls& controls = {}) {
        if (prepared.auralizer) {
            auralizer_ = std::move(prepared.auralizer);
            const double rate_hz = prepared.options.sample_rate_hz;
            auralizer_->begin_at(std::llround(begin_s_ * rate_hz) + silent_samples_);
            prepared.playback.follow(before_);
            mixer_ = std::make_unique<LiveMixer>(*auralizer_, kTakeBlock);
        } else {
            prepared.number = auralizer_->begin(prepared.built);
        }
        RoomState state = prepared.state(controls, mixer_->time_s());
        auralizer_->room().set_listener(state.listeners[0]);
        auralizer_->set_state(prepared.number, std::move(state));
        auralizer_->compute_first(mixer_->time_s());
    }

    // Of the scenes that have begun.
    LiveAuralizer& auralizer() { return *auralizer_; }
    LiveMixer& mixer() { return *mixer_; }

    /// Renders blocks as a device would. `before(block)` runs before each block and may begin a
    /// scene. Returns the first channel, silence before the first scene.
    std::vector<float> take(int blocks, const std::function<void(int)>& before) {
        std::vector<float> output;
        for (int block = 0; block < blocks; ++block) {
            before(block);
            output.resize(output.size() + kTakeBlock);
            if (!mixer_) {
                silent_samples_ += kTakeBlock;
                continue;
            }
            std::vector<std::vector<float>> channels(mixer_->channels(),
                                                     std::vector<float>(kTakeBlock));
            std::vector<float*> outputs;
            for (auto& channel : channels) outputs.push_back(channel.data());
            mixer_->render(outputs, kTakeBlock);
            std::copy(channels[0].begin(), channels[0].end(), output.end() - kTakeBlock);
        }
        return output;
    }

 private:
    double begin_s_;
    SignalStart before_;
    std::int64_t silent_samples_ = 0;
    std::unique_ptr<LiveAuralizer> auralizer_;
    std::unique_ptr<LiveMixer> mixer_;
};

}  // namespace aula::test
