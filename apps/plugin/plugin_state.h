#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "apps/plugin/plugin_room.h"

namespace aula::plugin {

/// The state of an instance, for formats whose hosts store bytes.
struct PluginState {
    RoomFiles files{};
    ControlValues controls = initial_values();
    /// The text that the state was read from: what a newer version has added to it is kept.
    std::string read_from{};
};

/// As JSON.
std::string write_state(const PluginState& state);

/// None if the text is no state. Controls that it does not have get their initial values.
std::optional<PluginState> read_state(std::string_view text);

}  // namespace aula::plugin
