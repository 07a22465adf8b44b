#pragma once

#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <vector>

#include "apps/room/auralizer/room_playback.h"

namespace aula {

/// Plays a room on the exact clock: samples are collected into blocks, which are rendered with the
/// frames and changes of their sample times. The latency is one block. Sample by sample
/// (AuralizerOptions::sample_by_sample) there is no latency: each call is rendered at its end, one
/// sample after the other, because results of the renderer depend on the division of the samples.
class ExactPlayback : public RoomPlayback {
 public:
    /// The largest number of samples that are rendered together.
    static constexpr int kBlock = 256;

    ExactPlayback(std::shared_ptr<BuiltRoom> first, const AuralizerOptions& options);

    void commit(std::int64_t until) override;
    int latency_samples() const override;
    void render(std::span<const SourceSignal> inputs, std::span<float* const> outputs,
                int samples) override;

 private:
    void compute_frames(Auralizer& auralizer) override;
    ChangeTime time_of(std::int64_t at) const override;
    void begin_source(SourceId source, const ChangeTime& time) override;
    void end_source(SourceId source, const ChangeTime& time) override;
    void turn_head(std::size_t listener, const Pose& pose, const ChangeTime& time) override;
    void take_scene(SoundingRoom& next) override;

    /// The times of frames from the beginning of a scene on.
    struct FrameTimes {
        /// The first sample at or after the time of a frame.
        std::int64_t sample(std::int64_t frame) const;
        double time_s(std::int64_t frame) const;

        double sample_rate_hz = 0;
        double frame_rate_hz = 0;
        std::int64_t begin = 0;  ///< sample of frame 0
    };

    /// Frames that are computed.
    struct Ready {
        ListenerFrames frames;
        std::int64_t tail_samples = 0;              ///< with these frames
        std::int64_t end = 0;                       ///< sample of the next frames
        std::unique_ptr<SoundingRoom> next_room{};  ///< that begins with these frames, or null
    };

    void render_block();
    void take_frames(std::int64_t sample);
    FrameTimes times_of(const BuiltRoom& room, std::int64_t begin) const;

    /// A source's signal in the present block.
    struct BlockInput {
        std::vector<float> samples;
        bool given = false;  ///< in this block
    };

    const int unit_;  ///< most samples that the renderer processes together

    // Used by the rendering thread.
    std::map<std::uint64_t, BlockInput> block_inputs_;  ///< by the source's number
    std::vector<std::vector<float>> block_outputs_;     ///< of the previous block
    int filled_ = 0;                                    ///< samples of the present block
    std::exception_ptr broken_;                         ///< the error that ended rendering
    std::int64_t next_frame_ = 0;                       ///< sample of the next frame
    std::vector<SourceSignal> block_signals_;
    std::vector<float*> block_pointers_;

    // Guarded by the mutex.
    ChangeQueue<RoomExchange<SoundingRoom>> renderer_changes_;
    std::int64_t committed_ = 0;  ///< all changes before it are known
    std::deque<Ready> ready_;     ///< computed, not yet rendered
    std::vector<std::vector<std::unique_ptr<RenderFrame>>> used_frames_;  ///< [listener] for reuse
    const SoundingRoom* used_by_;  ///< whose frames those are
};

}  // namespace aula
