#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "apps/room/auralizer/live_auralizer.h"
#include "apps/room/base/latency.h"
#include "apps/room/base/pause_fade.h"
#include "apps/room/frames/signals.h"
#include "apps/room/frames/timeline.h"
#include "audio/base/mailbox.h"
#include "audio/base/sample_ring.h"
#include "audio/dsp/fade.h"
#include "audio/dsp/limiter.h"

namespace aula {

/// A start of the signals of a scene.
struct SignalStart {
    std::uint64_t number = 0;  ///< equal for playbacks that continue each other's signals
    std::int64_t zero = 0;     ///< position of the signals' first sample
};

/// The signals of a scene as the audio thread plays them. Signals that begin with the scene are
/// played from their first sample on without a fade, except those that begin abruptly.
class ScenePlayback : public RoomSignals {
 public:
    /// One signal for each source of a scene. `block`: the largest number of samples of a call.
    /// `start`: number of the start of the signals. They continue those of the scene before with
    /// the same number, and otherwise begin with this one. 0: they begin with the first scene.
    ScenePlayback(SignalSet signals, const Timeline& timeline, double sample_rate_hz, int block,
                  std::uint64_t start);
    ~ScenePlayback() override;
    ScenePlayback(const ScenePlayback&) = delete;
    ScenePlayback& operator=(const ScenePlayback&) = delete;

    /// The start of the signals before the first scene of a mixer. [before it begins]
    void follow(const SignalStart& before) { before_ = before; }

    /// Exchanges the signals of the sources with a crossfade. [one thread at a time]
    Mailbox<SignalSet>& signals() { return next_signals_; }

    bool begin(std::int64_t sample, const RoomSignals* before) noexcept AULA_NONBLOCKING override;
    std::span<const SourceSignal> read(std::int64_t sample,
                                       int samples) noexcept AULA_NONBLOCKING override;
    void end(std::int64_t sample, std::span<float* const> outputs,
             int samples) const noexcept AULA_NONBLOCKING override;

 private:
    double rate_hz_;
    Timeline timeline_;
    SignalStart before_;  ///< of the first scene
    SignalStart start_;
    std::unique_ptr<SignalSet> first_signals_;
    SignalSet* signals_;
    SignalSet* fading_signals_ = nullptr;  ///< the signals being replaced
    Mailbox<SignalSet> next_signals_{2};   ///< present ones and those that fade out

    Fade signal_fade_;  ///< crossfade to other signals
    Fade onset_fade_;   ///< for signals that begin abruptly

    std::vector<std::vector<float>> inputs_;
    std::vector<SourceSignal> source_signals_;  ///< with the inputs
    std::vector<float> scratch_;
};

/// The audio thread's part of live playback: an auralizer and the limiter. Other threads read its
/// state by atomics or a ring.
class LiveMixer {
 public:
    /// The auralizer's scenes have signals.
    LiveMixer(LiveAuralizer& auralizer, int block);

    /// Fills the outputs, in blocks of at most the mixer's size. [audio thread, wait-free]
    void render(std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;

    /// The output, interleaved, for one reader after listen(true). Samples that do not fit are lost
    /// and counted, per channel. [the reader's thread]
    SampleRing& output_ring() { return output_ring_; }
    void listen(bool wanted) { listened_.store(wanted); }
    std::int64_t lost_samples() const { return lost_samples_.load(); }

    /// [any thread]
    double time_s() const { return static_cast<double>(auralizer_.rendered_samples()) / rate_hz_; }
    float take_peak() { return peak_.exchange(0); }
    float take_limiter_gain() { return limiter_gain_.exchange(1); }  ///< the least since
    std::size_t channels() const { return channels_; }

    /// Fades to silence, which stops the time, and back. [any thread]
    void pause(bool paused) { pause_.set_paused(paused); }
    bool silent() const { return pause_.silent(); }

    /// Latencies from a frame's stamp, and from a head pose, to the block that takes it. [any
    /// thread]
    const LatencyCounts& frame_latency() const { return frame_latency_; }
    const LatencyCounts& head_latency() const { return head_latency_; }

    /// Intervals between calls: the longest delay of a head pose. [any thread]
    const LatencyCounts& call_interval() const { return call_interval_; }

 private:
    void render_block(std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;
    void count_latencies(std::int64_t now_ns) noexcept AULA_NONBLOCKING;

    LiveAuralizer& auralizer_;
    double rate_hz_;
    int block_;
    std::size_t channels_;
    Limiter limiter_;
    std::vector<float*> output_pointers_;
    std::vector<float> interleaved_;
    SampleRing output_ring_;
    std::atomic<bool> listened_ = false;
    std::atomic<std::int64_t> lost_samples_ = 0;
    std::atomic<float> peak_ = 0;
    std::atomic<float> limiter_gain_ = 1;
    PauseFade pause_;
    std::int64_t frame_pose_ns_ = 0;  ///< of the newest frame
    std::int64_t head_pose_ns_ = 0;   ///< of the newest head
    LatencyCounts frame_latency_;
    LatencyCounts head_latency_;
    std::int64_t called_ns_ = 0;  ///< 0: no call yet
    LatencyCounts call_interval_;
};

}  // namespace aula
