#include "apps/plugin/presets.h"

#include <cmath>
#include <string>

namespace aula::plugin {

const std::vector<ShippedRoom>& shipped_rooms() {
    static const std::vector<ShippedRoom> rooms{{"live room", ""},
                                                {"bright room", "scenes/shoebox.json"},
                                                {"tiled bathroom", "scenes/bathroom.json"},
                                                {"church", "scenes/church.json"},
                                                {"museum", "scenes/museum.json"},
                                                {"corridor", "scenes/corridor.json"},
                                                {"two rooms", "scenes/two_rooms.json"},
                                                {"room with a door", "scenes/door.json"}};
    return rooms;
}

RoomFiles chosen_files(RoomFiles files, const ControlValues& values,
                       const std::filesystem::path& folder) {
    const auto room = static_cast<std::size_t>(std::lround(value_of(values, Control::room)));
    if (room == 0) return files;
    const std::string scene = shipped_rooms()[room - 1].scene;
    files.scene = scene.empty() ? std::filesystem::path{} : folder / scene;
    return files;
}

std::vector<Preset> presets() {
    const auto place = [](float x, float y, float z) { return Vec3(x, y, z); };
    return {
        {"live-room", "Live Room", ""},
        {"live-room-close", "Live Room, Close", "", place(4.6F, 3.9F, 1.5F),
         place(3.5F, 3.5F, 1.5F)},
        {"live-room-corner", "Live Room, Far Corner", "", place(8.6F, 6.4F, 1.2F),
         place(1.5F, 1.2F, 1.5F), 40},
        {"bright-room", "Bright Room", "scenes/shoebox.json", place(6.5F, 4.5F, 1.4F),
         place(3.2F, 3.6F, 1.6F)},
        {"tiled-bathroom", "Tiled Bathroom", "scenes/bathroom.json"},
        {"church-nave", "Church, Back of the Nave", "scenes/church.json"},
        {"church-choir", "Church, Near the Choir", "scenes/church.json", place(26.8F, -1, 1.6F),
         place(21, 0.5F, 1.65F)},
        {"museum", "Museum Halls", "scenes/museum.json"},
        {"corridor", "Corridor, Around the Corner", "scenes/corridor.json"},
        {"corridor-straight", "Corridor, Straight Ahead", "scenes/corridor.json",
         place(9, 1.2F, 1.5F), place(1.5F, 1, 1.65F)},
        {"next-room", "Voice from the Next Room", "scenes/two_rooms.json"},
        {"behind-the-door", "Behind the Door", "scenes/door.json"},
    };
}

}  // namespace aula::plugin
