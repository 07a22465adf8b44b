#include "apps/plugin/lv2/lv2_plugin.h"

#include <algorithm>
#include <utility>

#include "apps/plugin/lv2/ports.h"

namespace aula::plugin {

Lv2Plugin::Lv2Plugin(const PluginPorts& ports, const LV2_URID_Map* map)
    : output_(ports.output),
      messages_(map),
      plugin_(ports),
      outputs_(channel_count(ports.output)) {}

void Lv2Plugin::connect(std::uint32_t port, void* data) {
    const std::uint32_t first_control = control_port(output_, 0);
    if (port == kInputPort) {
        input_ = static_cast<const float*>(data);
    } else if (port < first_control) {
        outputs_[port - 1] = static_cast<float*>(data);
    } else if (port < freewheel_port(output_)) {
        controls_[port - first_control] = static_cast<const float*>(data);
    } else if (port == freewheel_port(output_)) {
        freewheel_ = static_cast<const float*>(data);
    } else if (port == latency_port(output_)) {
        latency_ = static_cast<float*>(data);
    } else if (port == messages_port(output_)) {
        control_ = static_cast<const LV2_Atom_Sequence*>(data);
    } else if (port == notify_port(output_)) {
        notify_ = static_cast<LV2_Atom_Sequence*>(data);
    } else if (port == level_port(output_)) {
        level_ = static_cast<float*>(data);
    } else if (port < level_port(output_)) {
        controls_[port - first_control - kPortsBetween] = static_cast<const float*>(data);
    }
}

/// Those of the ports; the initial value of a port that is not connected.
ControlValues Lv2Plugin::controls() const {
    ControlValues values = initial_values();
    for (std::size_t i = 0; i < kControls; ++i)
        if (controls_[i] != nullptr) values[i] = *controls_[i];
    return values;
}

LV2_State_Status Lv2Plugin::save(LV2_State_Store_Function store, LV2_State_Handle handle,
                                 const LV2_Feature* const* features) const {
    return messages_.save({.files = plugin_.files(), .unknown = unknown_}, store, handle, features);
}

void Lv2Plugin::restore(LV2_State_Retrieve_Function retrieve, LV2_State_Handle handle,
                        const LV2_Feature* const* features) {
    StoredFiles stored = messages_.restore(plugin_.files(), retrieve, handle, features);
    unknown_ = std::move(stored.unknown);
    plugin_.set_files(stored.files);
}

void Lv2Plugin::run(std::uint32_t samples) {
    plugin_.set_controls(controls());
    plugin_.set_offline(freewheels());
    messages_.begin(control_, notify_);
    std::size_t done = 0;
    while (const auto event = messages_.next()) {
        const auto at = static_cast<std::size_t>(std::clamp<std::int64_t>(
            event->offset, static_cast<std::int64_t>(done), std::int64_t{samples}));
        plugin_.process({&input_, 1}, outputs_, done, at);
        done = at;
        handle(*event);
    }
    plugin_.process({&input_, 1}, outputs_, done, samples);
    send_replies();
    messages_.end();
    if (latency_ != nullptr) *latency_ = 0;
    if (level_ != nullptr) *level_ = plugin_.level_db();
}

void Lv2Plugin::handle(const HostEvent& event) {
    switch (event.kind) {
        case HostEvent::Kind::set:
            plugin_.request(event.property, event.text);
            break;
        case HostEvent::Kind::get:
            plugin_.request_replies();
            break;
        case HostEvent::Kind::position:
            plugin_.move_transport(event.frame, event.speed != 0);
            break;
    }
}

void Lv2Plugin::send_replies() {
    MessageQueue& replies = plugin_.replies();
    while (const Message* const reply = replies.front()) {
        if (!messages_.send(*reply)) break;
        replies.pop();
    }
}

}  // namespace aula::plugin
