#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "apps/session/auralizer/source_slots.h"
#include "apps/session/frames/frame_maker.h"
#include "aula/auralizer.h"

namespace aula {

/// The room of a frame.
struct FrameRoom {
    RoomState state;
    SourceSlots slots;                            ///< of the sources that are present
    std::map<std::size_t, Material> materials{};  ///< of objects, changed since the frame before
};

/// A render frame for each listener.
using ListenerFrames = std::vector<std::unique_ptr<RenderFrame>>;

/// Computes the frames of an auralizer and describes the newest one.
class FrameComputer {
 public:
    FrameComputer(const Scene& scene, const FrameSettings& settings,
                  std::shared_ptr<const Hrtf> hrtf);

    const RendererConfig& config() const { return maker_.config(); }
    double response_length_s() const { return maker_.response_length_s(); }

    /// Fills a frame of each listener, and allocates those that are null. [propagation thread]
    void compute(const FrameRoom& room, ListenerFrames& frames);

    /// The longest delay of a source's paths in the newest frame; 0 if it is in none. Removed
    /// sources keep theirs. [propagation thread]
    double longest_delay_s(SourceId source) const { return maker_.longest_delay_s(source.number); }

    /// Counts frame times that were missed. [any thread]
    void count_late_frames(std::uint64_t frames);

    /// See Auralizer. [any thread]
    std::vector<std::vector<float>> impulse_response(SourceId source, std::size_t listener) const;
    bool visible(SourceId source, std::size_t listener) const;
    AuralizerStatus status() const;

 private:
    /// To which listeners a source is visible.
    struct Sight {
        SourceId source;
        std::vector<char> visible;  ///< [listener]
    };

    std::shared_ptr<const Hrtf> hrtf_;
    mutable std::mutex maker_mutex_;  ///< locked while a frame is computed
    FrameMaker maker_;
    mutable std::mutex mutex_;  ///< of what follows
    std::vector<Sight> sights_;
    AuralizerStatus status_;
    double frame_sum_ms_ = 0;
};

}  // namespace aula
