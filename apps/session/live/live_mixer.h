#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "apps/session/base/latency.h"
#include "apps/session/frames/signals.h"
#include "apps/session/frames/sound_at_listener.h"
#include "apps/session/frames/timeline.h"
#include "audio/base/mailbox.h"
#include "audio/base/sample_ring.h"
#include "audio/dsp/fade.h"
#include "audio/dsp/limiter.h"
#include "audio/render/renderer.h"

namespace aula {

/// An orientation of the head, and when it was given (clock_ns()).
struct HeadPose {
    Pose pose;
    std::int64_t given_ns = 0;
};

/// A scene as the audio thread plays it: signals through a renderer of its own. Where it takes up
/// signals that play its input is faded in; when something else follows its input is faded out and
/// the room rings out. So the sum of what ends and what begins hears every sample of the signals
/// once, whatever the two are, and nothing clicks. Signals that begin with the playback are heard
/// from their first sample on, but for those that begin in mid-wave.
class ScenePlayback {
 public:
    /// `starts_anew`: the signals begin with the playback; else they go on where they are.
    ScenePlayback(const RendererConfig& config, SignalSet signals, const Timeline& timeline,
                  std::shared_ptr<const Hrtf> hrtf, bool starts_anew);
    ~ScenePlayback();
    ScenePlayback(const ScenePlayback&) = delete;
    ScenePlayback& operator=(const ScenePlayback&) = delete;

    /// Where the frames to be heard go. [propagation thread]
    Mailbox<RenderFrame>& frames() { return renderer_.mailbox(); }

    /// Other signals for the same sources; they are crossfaded. [one thread at a time]
    Mailbox<SignalSet>& signals() { return next_signals_; }

 private:
    friend class LiveMixer;

    enum class State { playing, ringing, ending };

    void begin(std::int64_t position, const ScenePlayback* before) noexcept AULA_NONBLOCKING;
    void retire() noexcept AULA_NONBLOCKING;
    void end() noexcept AULA_NONBLOCKING;
    bool faded_in() const noexcept AULA_NONBLOCKING { return input_fade_.done(); }
    bool ended() const noexcept AULA_NONBLOCKING {
        return state_ == State::ending && output_fade_.done();
    }

    void read_inputs(std::int64_t position, int samples) noexcept AULA_NONBLOCKING;
    void render(std::int64_t position, std::span<float* const> sum,
                int samples) noexcept AULA_NONBLOCKING;

    double rate_hz_;
    Timeline timeline_;
    bool starts_anew_;
    std::int64_t zero_ = 0;  ///< position of the signals' first sample
    std::unique_ptr<SignalSet> first_signals_;
    SignalSet* signals_;
    SignalSet* fading_signals_ = nullptr;  ///< being replaced
    Mailbox<SignalSet> next_signals_{2};   ///< those that play, those that fade out
    Renderer renderer_;
    HeadMotion head_;

    State state_ = State::playing;
    Fade input_fade_;                ///< in while it plays, then out
    Fade output_fade_;               ///< out at the end
    Fade signal_fade_;               ///< to other signals
    Fade rise_;                      ///< of signals that begin in mid-wave
    std::int64_t ring_samples_ = 0;  ///< left of the ringing out

    std::vector<std::vector<float>> inputs_;
    std::vector<const float*> input_pointers_;
    std::vector<std::vector<float>> outputs_;
    std::vector<float*> output_pointers_;
    std::vector<float> scratch_;
};

/// The audio thread's part of live playing: the playback that plays, those that ring out, the
/// limiter. What other threads read of it is atomic or goes through a ring.
class LiveMixer {
 public:
    LiveMixer(double sample_rate_hz, int block, std::size_t channels);
    ~LiveMixer();

    /// Fills the outputs, in blocks of our own size where the device asks for more.
    /// [audio thread, wait-free]
    void render(std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;

    /// What is to be played from now on, each with a first frame in it; what was played rings out.
    /// Spent playbacks come back. [propagation thread]
    Mailbox<ScenePlayback>& playbacks() { return playbacks_; }
    Mailbox<HeadPose>& head_poses() { return head_poses_; }

    /// What is heard, interleaved, for one reader that asked for it with listen(). What finds no
    /// room is lost, and counted, in samples of a channel. [the reader's thread]
    SampleRing& heard() { return heard_; }
    void listen(bool wanted) { listened_.store(wanted); }
    std::int64_t lost_samples() const { return lost_samples_.load(); }

    /// [any thread]
    double time_s() const { return static_cast<double>(position_.load()) / rate_hz_; }
    float take_peak() { return peak_.exchange(0); }
    float take_limiter_gain() { return limiter_gain_.exchange(1); }  ///< the least since
    std::size_t channels() const { return channels_; }

    /// Samples of all channels that were muted because they were not finite. [any thread]
    std::int64_t muted_samples() const { return muted_samples_.load(); }

    /// Fades to silence, where time stands still, and back. [any thread]
    void pause(bool paused) { paused_.store(paused); }
    bool silent() const { return silent_.load(); }  ///< a pause is all there

    /// From a frame's stamp to the block that takes it, and the same of head poses. [any thread]
    const LatencyCounts& frame_latency() const { return frame_latency_; }
    const LatencyCounts& head_latency() const { return head_latency_; }

    /// From one call for sound to the next: what a head pose waits at most. [any thread]
    const LatencyCounts& call_interval() const { return call_interval_; }

 private:
    static constexpr std::size_t kMaxRinging = 2;

    void render_block(std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;
    void follow_head(std::int64_t now_ns) noexcept AULA_NONBLOCKING;
    void fade_pause(std::span<float* const> outputs, int samples) noexcept AULA_NONBLOCKING;
    void change_playback() noexcept AULA_NONBLOCKING;
    void give_back_ended() noexcept AULA_NONBLOCKING;

    double rate_hz_;
    int block_;
    std::size_t channels_;
    Limiter limiter_;
    Mailbox<ScenePlayback> playbacks_{kMaxRinging + 2};  ///< one that plays, one that waits
    Mailbox<HeadPose> head_poses_{1};
    ScenePlayback* playing_ = nullptr;
    ScenePlayback* waiting_ = nullptr;  ///< for a place among the ringing ones
    std::array<ScenePlayback*, kMaxRinging> ringing_{};
    Pose head_;
    bool head_known_ = false;
    std::vector<float*> output_pointers_;
    std::vector<float> interleaved_;
    SampleRing heard_;
    std::atomic<bool> listened_ = false;
    std::atomic<std::int64_t> lost_samples_ = 0;
    std::atomic<std::int64_t> position_ = 0;
    std::atomic<std::int64_t> muted_samples_ = 0;
    std::atomic<float> peak_ = 0;
    std::atomic<float> limiter_gain_ = 1;
    std::atomic<bool> paused_ = false;
    std::atomic<bool> silent_ = false;
    Fade pause_fade_;
    bool fading_out_ = false;  ///< along it, else in
    std::int64_t newest_stamp_ = 0;
    LatencyCounts frame_latency_;
    LatencyCounts head_latency_;
    std::int64_t called_ns_ = 0;  ///< 0: not yet
    LatencyCounts call_interval_;
};

}  // namespace aula
