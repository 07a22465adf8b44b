#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "apps/plugin/host_messages.h"
#include "apps/plugin/ports.h"
#include "apps/plugin/room_loader.h"
#include "audio/dsp/fade.h"
#include "audio/spatial/moving_path.h"

namespace aula::plugin {

/// An instance of a plugin: a source in a room, heard by a listener. While the host plays, the
/// room is on the real-time clock, and run() never waits. While the host renders (freewheel), it
/// is a new room on the exact clock, begun at the first sample after the host has started to render
/// or has moved its transport: the same range gives the same bytes for any sizes of blocks.
class RoomPlugin {
 public:
    /// `block`: the size of most blocks. `map` may be null.
    RoomPlugin(const Layout& layout, double sample_rate_hz, int block, const LV2_URID_Map* map);
    ~RoomPlugin();
    RoomPlugin(const RoomPlugin&) = delete;
    RoomPlugin& operator=(const RoomPlugin&) = delete;

    void connect(std::uint32_t port, void* data);
    void activate();
    void deactivate();

    /// Processes a block of any size. Outputs may be the input's memory. [audio thread]
    void run(std::uint32_t samples);

    LV2_State_Status save(LV2_State_Store_Function store, LV2_State_Handle handle,
                          const LV2_Feature* const* features) const;
    void restore(LV2_State_Retrieve_Function retrieve, LV2_State_Handle handle,
                 const LV2_Feature* const* features);

 private:
    void read_controls();
    void handle(const HostEvent& event);
    void process(std::int64_t first, std::int64_t last);
    void begin_exact();
    void render_exact(std::span<float* const> outputs, std::size_t samples);
    void render_live(std::span<float* const> outputs, std::size_t samples);
    void mix(std::span<float* const> outputs, std::size_t samples);
    void send_replies();
    void give_back_rooms();
    float target_wet() const;
    bool freewheels() const { return value_of(values_, Control::freewheel) > 0.5F; }

    static constexpr std::size_t kChunk = 1024;

    const OutputFormat output_;
    const std::size_t channels_;
    HostMessages messages_;
    RoomLoader loader_;

    const float* input_ = nullptr;
    std::vector<float*> outputs_;
    std::array<float*, kControls> controls_{};
    const LV2_Atom_Sequence* control_ = nullptr;
    LV2_Atom_Sequence* notify_ = nullptr;
    ControlValues values_;

    // On the real-time clock.
    bool is_open_ = false;  ///< a room is being built, or was
    float group_ = 0;       ///< of that room
    PluginRoom* current_ = nullptr;
    PluginRoom* ringing_ = nullptr;  ///< the room before it, which fades out
    std::int64_t ringing_samples_ = 0;
    Fade fade_;  ///< of the input from the ringing to the current room

    // On the exact clock.
    std::unique_ptr<OwnRoom> exact_;
    std::atomic<bool> is_restored_ = false;  ///< it has other files than the state
    bool is_fresh_ = false;                  ///< it has rendered no sample
    bool rolls_ = false;                     ///< the transport
    std::int64_t transport_ = 0;

    bool started_ = false;  ///< samples have been processed since activate()
    Glide wet_;
    std::array<float, kChunk> dry_{};
    std::array<float, kChunk> room_input_{};
    std::array<float, kChunk> weights_{};
    std::vector<std::vector<float>> ringing_outputs_;
    std::vector<float*> ringing_pointers_;
    std::vector<float*> chunk_outputs_;
};

}  // namespace aula::plugin
