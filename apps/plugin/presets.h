#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "apps/plugin/plugin_room.h"

namespace aula::plugin {

/// A scene that ships with the plugins.
struct ShippedRoom {
    const char* name;
    const char* scene;  ///< file beside the plugins, or empty: the default room
};

/// By the values of the control `room` from 1 on, which hosts store: new rooms come last.
const std::vector<ShippedRoom>& shipped_rooms();

/// `files` with the scene that the control `room` chooses, of the shipped ones in `folder`.
RoomFiles chosen_files(RoomFiles files, const ControlValues& values,
                       const std::filesystem::path& folder);

/// Places in a room that ships with the plugins.
struct Preset {
    const char* id;     ///< of its URI
    const char* name;   ///< for the menu of a host
    const char* scene;  ///< file in the bundle, or empty: the default room
    // Absent: the scene's own place.
    std::optional<Vec3> source{};
    std::optional<Vec3> listener{};
    /// With a place of the listener. Not 0, which is the orientation of the scene.
    float listener_yaw_deg = 0.01F;
};

/// All presets, in the order of the menu.
std::vector<Preset> presets();

}  // namespace aula::plugin
