#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "apps/plugin/plugin_state.h"
#include "apps/plugin/room_plugin.h"

namespace aula::plugin {

/// An instance for hosts that have parameters by number, store the state as bytes and tell the
/// sample rate when it is activated.
class PluginInstance {
 public:
    /// `folder`: that of the scenes that ship with the plugins.
    PluginInstance(const Kind& kind, std::filesystem::path folder);
    PluginInstance(const PluginInstance&) = delete;
    PluginInstance& operator=(const PluginInstance&) = delete;

    const Kind& kind() const { return kind_; }
    bool is_active() const { return plugin_ != nullptr; }

    // [main thread]
    /// False at a sample rate that is not allowed, or if it is active.
    bool activate(double sample_rate_hz, std::uint32_t longest_block);
    void deactivate();
    std::string state() const;
    /// False if the text is no state.
    bool set_state(std::string_view text);
    /// A status that is not the last one; empty: none.
    std::string new_status();
    /// The present status; empty: none.
    std::string status() const { return plugin_ ? plugin_->status() : std::string(); }
    RoomFiles files() const { return plugin_ ? plugin_->files() : files_; }
    /// Replaces the scene of the state, and waits until it is heard.
    void choose_scene(const std::filesystem::path& file);
    const std::filesystem::path& folder() const { return folder_; }
    ControlValues values() const;

    // [any thread]
    /// The value of a parameter: a control's; that of `enabled` is the bypass, its opposite.
    double parameter(Control control) const;
    void set_parameter(Control control, double value);
    /// Takes effect with the next block.
    void set_offline(bool is_offline) { is_offline_ = is_offline; }
    std::uint32_t tail_samples() const;

    /// As RoomPlugin::level_db(); silence while it is not active. [main thread]
    float level_db() const { return plugin_ ? plugin_->level_db() : -120.0F; }

    // [audio thread, while active]
    /// Begins a block. The host's transport is at a sample; as its time may be rounded, a sample
    /// more or less is no jump.
    void begin_block(std::int64_t transport, bool rolls);
    /// Processes the samples from `first` to `last` of buffers with the present parameters.
    void process(std::span<const float* const> inputs, std::span<float* const> outputs,
                 std::size_t first, std::size_t last);
    /// Ends a block; true if the status may be a new one.
    bool end_block();
    /// The rendering offline begins anew.
    void restart() { plugin_->restart(); }

 private:
    const Kind& kind_;
    const std::filesystem::path folder_;
    std::array<std::atomic<float>, kControls> values_;
    std::atomic<bool> is_offline_ = false;

    RoomFiles files_;        ///< while there is no plugin
    std::string read_from_;  ///< the last state
    std::string reported_;   ///< the last status

    std::unique_ptr<RoomPlugin> plugin_;  ///< while active
    bool rolls_ = false;
    std::int64_t transport_ = 0;  ///< at the end of what is processed
};

}  // namespace aula::plugin
