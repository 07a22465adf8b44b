#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "apps/room/auralizer/room_renderer.h"
#include "apps/room/auralizer/source_slots.h"
#include "audio/base/mailbox.h"

namespace aula {

/// An orientation of a head, and when it was set (clock_ns(); 0 if its latency does not count).
struct HeadPose {
    Pose pose;
    std::int64_t set_ns = 0;
};

/// Signals that a room plays in place of the inputs of render(), with the sample time of the
/// auralizer. [rendering thread]
class RoomSignals {
 public:
    virtual ~RoomSignals() = default;

    /// The room begins to play, after one with signals or null. Returns whether its input fades in.
    virtual bool begin(std::int64_t sample,
                       const RoomSignals* before) noexcept AULA_NONBLOCKING = 0;

    /// The signals of the next samples.
    virtual std::span<const SourceSignal> read(std::int64_t sample,
                                               int samples) noexcept AULA_NONBLOCKING = 0;

    /// Ends the sound of the room at the end of the playback.
    virtual void end(std::int64_t sample, std::span<float* const> outputs,
                     int samples) const noexcept AULA_NONBLOCKING = 0;
};

/// The renderers of a scene of an auralizer, and mailboxes for their sources and head poses. Any
/// thread uses it until it sounds, then the rendering thread; on the real-time clock other threads
/// use the mailboxes.
struct SoundingRoom {
    SoundingRoom(const RendererConfig& config, std::size_t listeners,
                 const std::shared_ptr<const Hrtf>& hrtf, const HeadphoneFilter* headphones)
        : renderer(config, listeners, hrtf, headphones), slots(config.sources) {
        for (std::size_t l = 0; l < listeners; ++l)
            heads.push_back(std::make_unique<Mailbox<HeadPose>>(1));
    }

    /// Begins with the sources that are present and the orientations of the listeners' heads.
    void begin(const SourceSlots& present, const std::vector<Pose>& listeners) {
        slots = present;
        for (std::size_t s = 0; s < slots.playing().size(); ++s)
            renderer.set_source(s, slots.playing()[s]);
        for (std::size_t l = 0; l < listeners.size(); ++l) renderer.turn_head(l, listeners[l]);
    }

    bool plays(SourceId source) const {
        const std::vector<SourceId>& playing = slots.playing();
        return std::find(playing.begin(), playing.end(), source) != playing.end();
    }

    /// How long it is heard after its signals have ended.
    std::int64_t tail_samples() const noexcept AULA_NONBLOCKING {
        return tail.load(std::memory_order_relaxed);
    }

    RoomRenderer renderer;
    SourceSlots slots;                     ///< the newest assignment for the renderer
    std::unique_ptr<RoomSignals> signals;  ///< null: the inputs of render()
    std::atomic<std::int64_t> tail = 0;    ///< tail_samples() with the newest frame

    // On the real-time clock.
    Mailbox<std::vector<SourceId>> routes{1};               ///< [slot]
    std::vector<std::unique_ptr<Mailbox<HeadPose>>> heads;  ///< [listener]
};

}  // namespace aula
