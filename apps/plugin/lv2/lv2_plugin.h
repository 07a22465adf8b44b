#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "apps/plugin/lv2/host_messages.h"
#include "apps/plugin/room_plugin.h"

namespace aula::plugin {

/// An instance of an LV2 plugin: connects ports, messages and the state with a RoomPlugin.
class Lv2Plugin {
 public:
    /// `map` may be null.
    Lv2Plugin(const PluginPorts& ports, const LV2_URID_Map* map);

    void connect(std::uint32_t port, void* data);
    void activate() { plugin_.activate(controls(), freewheels()); }
    void deactivate() { plugin_.deactivate(); }

    /// Processes a block of any size. Outputs may be the input's memory. [audio thread]
    void run(std::uint32_t samples);

    LV2_State_Status save(LV2_State_Store_Function store, LV2_State_Handle handle,
                          const LV2_Feature* const* features) const;
    void restore(LV2_State_Retrieve_Function retrieve, LV2_State_Handle handle,
                 const LV2_Feature* const* features);

 private:
    ControlValues controls() const;
    bool freewheels() const { return freewheel_ != nullptr && *freewheel_ > 0.5F; }
    void handle(const HostEvent& event);
    void send_replies();

    const OutputFormat output_;
    HostMessages messages_;
    RoomPlugin plugin_;
    std::vector<UnknownProperty> unknown_;  ///< of the state

    const float* input_ = nullptr;
    std::vector<float*> outputs_;
    std::array<const float*, kControls> controls_{};
    const float* freewheel_ = nullptr;
    float* latency_ = nullptr;
    float* level_ = nullptr;
    const LV2_Atom_Sequence* control_ = nullptr;
    LV2_Atom_Sequence* notify_ = nullptr;
};

}  // namespace aula::plugin
