#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "apps/room/auralizer/source_slots.h"
#include "apps/room/frames/frame_maker.h"
#include "aula/auralizer.h"

namespace aula {

struct BuiltRoom;

/// The room of a frame.
struct FrameRoom {
    std::shared_ptr<BuiltRoom> built{};
    std::uint64_t scene = 0;  ///< number of the scene, in the order of the calls
    RoomState state;
    SourceSlots slots;                            ///< of the sources that are present
    std::map<std::size_t, Material> materials{};  ///< of objects, changed since the previous frame
    /// [listener] When the first pose since the previous frame was set (clock_ns()); 0: no pose
    /// whose latency counts.
    std::vector<std::int64_t> poses_ns{};
};

/// A render frame for each listener.
using ListenerFrames = std::vector<std::unique_ptr<RenderFrame>>;

/// Computes the frames of an auralizer and describes the newest one.
class FrameComputer {
 public:
    FrameComputer(const Scene& scene, const FrameSettings& settings,
                  std::shared_ptr<const Hrtf> hrtf);

    const RendererConfig& config() const { return config_; }
    const std::shared_ptr<const Hrtf>& hrtf() const { return hrtf_; }
    double response_length_s() const { return response_length_s_; }
    float patch_size_m() const { return patch_size_m_; }

    /// Fills a frame of each listener, and allocates those that are null. [propagation thread]
    void compute(const FrameRoom& room, ListenerFrames& frames);

    /// The longest delay of a source's paths in the newest frame; 0 if it is in none. Removed
    /// sources keep theirs. [propagation thread]
    double longest_delay_s(SourceId source) const { return maker_->longest_delay_s(source.number); }

    /// Removes the sources of the scene. Before the first frame.
    void remove_sources() { maker_->take_sources({}); }

    /// Fills the caches for the state with which another scene begins, which reduces its initial
    /// noise: for at most about a quarter of a second. Before the first frame.
    void warm_up(const RoomState& state) { maker_->warm_up(state, kWarmUp_s); }

    /// The object that computes the frames. [propagation thread]
    const FrameMaker& maker() const { return *maker_; }

    /// Continues the counts of frames of another one, of the scene before; also of silent ones.
    void continue_counts(const FrameComputer& before);

    /// Frees the engine. No frame is computed during or after the call.
    void end();

    /// Notes that the newest frame has been handed over. [any thread]
    void set_handed_over();

    /// Counts frame times that were missed. [any thread]
    void count_skipped_frames(std::uint64_t frames);

    /// See Auralizer. [any thread]
    std::vector<std::vector<float>> impulse_response(SourceId source, std::size_t listener) const;
    bool visible(SourceId source, std::size_t listener) const;
    bool silent(SourceId source, std::size_t listener) const;
    AuralizerStatus status() const;

 private:
    static constexpr double kWarmUp_s = 0.25;

    /// After this time a pair is silent, s. With few rays a frame may contain nothing of a source
    /// behind a small opening. A choice: half a second, as ResponseFollower::kMostFrames.
    static constexpr double kSilent_s = 0.5;

    /// A source at a listener.
    struct PairState {
        bool visible = false;
        /// Frames since something of the source has reached the listener.
        std::int64_t silent_frames = 0;
    };
    struct SourcePairs {
        SourceId source;
        std::vector<PairState> at;  ///< [listener]
    };

    const PairState* find_pair(SourceId source, std::size_t listener) const;
    bool is_silent(const PairState& pair) const {
        return static_cast<double>(pair.silent_frames) * config_.frame_s >= kSilent_s;
    }

    std::shared_ptr<const Hrtf> hrtf_;
    mutable std::mutex maker_mutex_;   ///< locked while a frame is computed
    std::optional<FrameMaker> maker_;  ///< until end()
    const RendererConfig config_;
    const double response_length_s_;
    const float patch_size_m_;
    mutable std::mutex mutex_;        ///< protects the following members
    std::vector<SourcePairs> pairs_;  ///< changed by the propagation thread
    AuralizerStatus status_;
    double frame_sum_ms_ = 0;
    double counted_sum_ms_ = 0;
    std::optional<std::chrono::steady_clock::time_point> handed_over_;
};

}  // namespace aula
