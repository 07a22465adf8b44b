#include "apps/plugin/ports.h"

#include <algorithm>
#include <cmath>

#include "apps/plugin/default_room.h"

namespace aula::plugin {

namespace {

/// Largest coordinate, m: the largest rooms that ship are 60 m long.
constexpr float kFarthest_m = 100;

ControlPort coordinate(const char* symbol, const char* name, const char* group, float initial) {
    return {.symbol = symbol,
            .name = name,
            .least = -kFarthest_m,
            .greatest = kFarthest_m,
            .initial = initial,
            .unit = "m",
            .group = group};
}

ControlPort angle(const char* symbol, const char* name, float greatest, const char* comment) {
    return {.symbol = symbol,
            .name = name,
            .least = -greatest,
            .greatest = greatest,
            .initial = 0,
            .unit = "degree",
            .group = "listener",
            .comment = comment};
}

ControlPort toggle(const char* symbol, const char* name) {
    return {.symbol = symbol,
            .name = name,
            .least = 0,
            .greatest = 1,
            .initial = 1,
            .kind = ControlPort::Kind::toggle,
            .group = "sound"};
}

std::vector<ControlPort> make_ports() {
    const Scene room = default_room();
    const Vec3 source = room.sources[0].position;
    const Vec3 listener = room.listener.pose.position;
    return {
        coordinate("source_x", "Source X (front)", "source", source.x),
        coordinate("source_y", "Source Y (left)", "source", source.y),
        coordinate("source_z", "Source Z (up)", "source", source.z),
        coordinate("listener_x", "Listener X (front)", "listener", listener.x),
        coordinate("listener_y", "Listener Y (left)", "listener", listener.y),
        coordinate("listener_z", "Listener Z (up)", "listener", listener.z),
        angle("listener_yaw", "Listener Yaw", 180, "Positive turns to the left; 0 looks along X."),
        angle("listener_pitch", "Listener Pitch", 90, "Positive looks up."),
        angle("listener_roll", "Listener Roll", 180, "Positive lowers the right ear."),
        {.symbol = "gain_db",
         .name = "Source Gain",
         .least = -60,
         .greatest = 24,
         .initial = 0,
         .unit = "db",
         .group = "source"},
        toggle("direct", "Direct Sound"),
        toggle("early", "Early Reflections"),
        toggle("late", "Late Reverberation"),
        {.symbol = "wet",
         .name = "Wet",
         .least = 0,
         .greatest = 1,
         .initial = 1,
         .unit = "coef",
         .group = "sound",
         .comment = "1: the sound in the room; 0: the input."},
        {.symbol = "quality",
         .name = "Quality",
         .least = 0,
         .greatest = 2,
         .initial = 1,
         .kind = ControlPort::Kind::enumeration,
         .scale_points = {"draft", "normal", "fine"},
         .comment = "Rays in each propagation frame: a quarter, as many as the scene says, or four "
                    "times as many."},
        {.symbol = "room_group",
         .name = "Room Group",
         .least = 0,
         .greatest = 16,
         .initial = 0,
         .kind = ControlPort::Kind::integer,
         .comment = "Instances of one group share their room; 0: a separate room."},
        {.symbol = "enabled",
         .name = "Enabled",
         .least = 0,
         .greatest = 1,
         .initial = 1,
         .kind = ControlPort::Kind::toggle,
         .designation = "lv2:enabled"},
        {.symbol = "freewheel",
         .name = "Freewheel",
         .least = 0,
         .greatest = 1,
         .initial = 0,
         .kind = ControlPort::Kind::toggle,
         .designation = "lv2:freeWheeling",
         .comment = "Renders on the exact clock; processing may take longer than real time."},
        {.symbol = "latency",
         .name = "Latency",
         .least = 0,
         .greatest = 8192,
         .initial = 0,
         .kind = ControlPort::Kind::integer,
         .unit = "frame",
         .designation = "lv2:latency",
         .output = true},
    };
}

}  // namespace

const std::vector<ControlPort>& control_ports() {
    static const std::vector<ControlPort> ports = make_ports();
    return ports;
}

float valid(Control control, float value) {
    const ControlPort& port = control_ports()[static_cast<std::size_t>(control)];
    if (std::isnan(value)) return port.initial;
    return std::clamp(value, port.least, port.greatest);
}

}  // namespace aula::plugin
