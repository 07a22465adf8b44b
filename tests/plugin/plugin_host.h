#pragma once

#include <lv2/atom/atom.h>
#include <lv2/atom/forge.h>
#include <lv2/core/lv2.h>
#include <lv2/state/state.h>
#include <lv2/urid/urid.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "apps/plugin/lv2/ports.h"
#include "tests/plugin/channels.h"
#include "tests/support/realtime_trap.h"

namespace aula::test {

/// Properties of a plugin's state, by URI, with their values' bytes.
using StoredState = std::map<std::string, std::pair<std::string, std::vector<char>>>;

/// URIs of properties.
inline const std::string kScene = AULA_PLUGIN_URI "#scene";
inline const std::string kHrtf = AULA_PLUGIN_URI "#hrtf";
inline const std::string kStatus = AULA_PLUGIN_URI "#status";

/// A host of the built binary: an instance with all ports connected, all controls at their initial
/// values.
class PluginHost {
 public:
    explicit PluginHost(OutputFormat layout, double rate_hz = 48000);
    ~PluginHost();
    PluginHost(const PluginHost&) = delete;
    PluginHost& operator=(const PluginHost&) = delete;

    void set(plugin::Control control, float value) {
        controls_[static_cast<std::size_t>(control)] = value;
    }
    float get(plugin::Control control) const {
        return controls_[static_cast<std::size_t>(control)];
    }

    void set_freewheel(float value) { freewheel_ = value; }
    /// What the plugin has written.
    float latency() const { return latency_; }
    float level_db() const { return level_db_; }

    void activate();
    void deactivate();

    /// Sends messages with the next block.
    void send_path(const std::string& property, const std::string& path);
    void send_get();
    void send_position(std::int64_t frame, float speed);

    /// Processes a signal with calls of the given sizes, repeated. The first output is the memory
    /// of the input.
    Channels run(std::span<const float> input, const std::vector<std::size_t>& sizes);

    /// What run() of the plugin did from now on that an audio thread must not do.
    void watch(RealtimeViolations& violations) { violations_ = &violations; }

    /// The newest text of a property that the plugin has sent; "-" if there was none.
    std::string received(const std::string& property) const;

    StoredState save() const;
    void restore(const StoredState& state);

 private:
    void run_block(const float* input, std::size_t samples, Channels& output);
    void receive();
    LV2_URID urid(const std::string& uri) const;
    static LV2_URID map_uri(LV2_URID_Map_Handle handle, const char* uri);

    OutputFormat layout_;
    mutable std::vector<std::string> uris_;
    LV2_URID_Map map_{};
    const LV2_Descriptor* descriptor_ = nullptr;
    LV2_Handle handle_ = nullptr;
    bool active_ = false;
    plugin::ControlValues controls_;
    float freewheel_ = 0;
    float latency_ = 99;
    float level_db_ = 99;
    LV2_Atom_Forge forge_{};
    LV2_Atom_Forge_Frame sequence_{};
    alignas(8) std::array<std::uint8_t, 16384> control_{};
    alignas(8) std::array<std::uint8_t, 65536> notify_{};
    std::map<std::string, std::string> received_;
    RealtimeViolations* violations_ = nullptr;
};

/// Runs silence until a condition holds, for at most 60 s.
template <typename Condition>
bool run_until(PluginHost& host, Condition&& holds) {
    using namespace std::chrono_literals;
    const auto end = std::chrono::steady_clock::now() + 60s;
    const std::vector<float> silence(256);
    while (!holds()) {
        if (std::chrono::steady_clock::now() > end) return false;
        host.run(silence, {256});
        std::this_thread::sleep_for(1ms);
    }
    return true;
}

}  // namespace aula::test
