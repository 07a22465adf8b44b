#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/plugin/controls.h"
#include "apps/plugin/room_loader.h"
#include "apps/room/base/room_exchange.h"
#include "audio/spatial/moving_path.h"

namespace aula::plugin {

/// An instance of a plugin of any format: one or two sources in a room, heard by a listener. While
/// the host plays, the room is on the real-time clock, and process() never waits. While the host
/// renders offline, it is a new room on the exact clock, begun at the first sample after the host
/// has started to render or has moved its transport: the same range gives the same bytes for any
/// sizes of blocks.
class RoomPlugin {
 public:
    explicit RoomPlugin(const PluginPorts& ports);
    ~RoomPlugin();
    RoomPlugin(const RoomPlugin&) = delete;
    RoomPlugin& operator=(const RoomPlugin&) = delete;

    /// Builds a room, and waits until it is heard; a host that only renders needs none. [not the
    /// audio thread]
    void activate(const ControlValues& values, bool is_offline);
    void deactivate();

    // [audio thread]
    /// The values from the next sample on; those that are not valid are made valid.
    void set_controls(const ControlValues& values);
    /// Whether the host renders offline: process() may wait.
    void set_offline(bool is_offline);
    /// The host's transport is at a sample, and moves with the samples if it rolls.
    void move_transport(std::int64_t sample, bool rolls);
    /// The rendering offline begins anew.
    void restart();
    /// Asks for another file; false if there were too many requests.
    bool request(Property property, std::string_view file);
    /// Changes and errors for the host, and the request for all of them.
    MessageQueue& replies() { return loader_.replies(); }
    void request_replies() { loader_.request_replies(); }
    /// Processes the samples from `first` to `last` of buffers. Outputs may be the inputs' memory.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t first, std::size_t last);

    // [not the audio thread]
    RoomFiles files() const { return loader_.files(); }
    void set_files(const RoomFiles& files);
    /// Does not wait for the room.
    void change_files(const RoomFiles& files);
    /// An error's line, or what the host should know; empty: nothing.
    std::string status() const { return loader_.status(); }
    /// How long the present room is heard after its input has ended. [any thread]
    std::int64_t tail_samples() const { return tail_samples_; }
    /// Peak of the output, dB re full scale; it falls slowly. [any thread]
    float level_db() const { return level_db_; }

 private:
    void begin_exact();
    void render_exact(std::size_t samples);
    void render_live(std::size_t samples);
    void mix(std::size_t samples);
    void measure_level(std::size_t samples);
    void give_back_rooms();
    float target_wet() const;

    static constexpr std::size_t kChunk = 1024;
    static constexpr float kSilence_db = -120;

    const OutputFormat output_;
    const std::size_t channels_;
    const double sample_rate_hz_;
    RoomLoader loader_;

    ControlValues values_;
    bool is_offline_ = false;

    // On the real-time clock.
    bool is_open_ = false;  ///< a room is being built, or was
    float group_ = 0;       ///< of that room
    float room_ = 0;        ///< the same, on both clocks
    RoomExchange<PluginRoom, RoomLoader> rooms_;

    // On the exact clock.
    std::unique_ptr<OwnRoom> exact_;
    std::atomic<bool> is_restored_ = false;  ///< it has other files than the state
    bool is_fresh_ = false;                  ///< it has rendered no sample
    bool rolls_ = false;                     ///< the transport
    std::int64_t transport_ = 0;

    std::atomic<std::int64_t> tail_samples_ = 0;
    std::atomic<float> level_db_ = kSilence_db;
    bool started_ = false;  ///< samples have been processed since activate()
    Glide wet_;
    std::vector<std::vector<float>> dry_;         ///< [source]
    std::vector<std::vector<float>> room_input_;  ///< [source]
    std::vector<const float*> dry_pointers_;
    std::vector<const float*> room_input_pointers_;
    std::array<float, kChunk> weights_{};
    std::vector<std::vector<float>> room_outputs_;  ///< [channel]
    std::vector<float*> room_output_pointers_;
    std::vector<float*> chunk_outputs_;
};

}  // namespace aula::plugin
