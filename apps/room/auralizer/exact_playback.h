#pragma once

#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <optional>
#include <vector>

#include "apps/room/auralizer/room_playback.h"

namespace aula {

/// Plays a room on the exact clock: samples are collected into blocks, which are rendered with the
/// frames and changes of their sample times. The latency is one block. Sample by sample
/// (AuralizerOptions::sample_by_sample) there is no latency: each call is rendered at its end, one
/// sample after the other, because results of the renderer depend on the division of the samples.
class ExactPlayback : public RoomPlayback {
 public:
    ExactPlayback(const Scene& scene, const AuralizerOptions& options,
                  std::shared_ptr<const Hrtf> hrtf);

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

    std::int64_t frame_start(std::int64_t frame) const;
    void render_block();
    void take_frames();

    /// Frames that are computed, and tail_samples() with them.
    struct Ready {
        ListenerFrames frames;
        std::int64_t tail_samples = 0;
    };

    /// A source's signal in the present block.
    struct BlockInput {
        std::vector<float> samples;
        bool given = false;  ///< in this block
    };

    const double frame_rate_hz_;
    const int unit_;                      ///< most samples that the renderer processes together
    const std::optional<double> work_s_;  ///< counted time of a frame, see RoomState
    const std::size_t frames_ahead_;

    // Used by the rendering thread.
    std::map<std::uint64_t, BlockInput> block_inputs_;  ///< by the source's number
    std::vector<std::vector<float>> block_outputs_;     ///< of the previous block
    int filled_ = 0;                                    ///< samples of the present block
    std::exception_ptr broken_;                         ///< the error that ended rendering
    std::int64_t next_frame_ = 0;                       ///< the next to be rendered
    std::vector<SourceSignal> block_signals_;
    std::vector<float*> block_pointers_;

    // Guarded by the mutex.
    ChangeQueue<RoomRenderer> renderer_changes_;
    std::int64_t committed_ = 0;  ///< all changes before it are known
    std::deque<Ready> ready_;     ///< computed, not yet rendered
    std::vector<std::vector<std::unique_ptr<RenderFrame>>> used_frames_;  ///< [listener] for reuse
};

}  // namespace aula
