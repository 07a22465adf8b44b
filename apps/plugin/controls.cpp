#include "apps/plugin/controls.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <system_error>

#include "apps/output/formatted.h"
#include "apps/plugin/default_room.h"
#include "apps/plugin/presets.h"

namespace aula::plugin {

namespace {

/// Largest coordinate, m: the largest rooms that ship are 60 m long.
constexpr float kFarthest_m = 100;

/// Labels of the values of a toggle.
constexpr std::array<const char*, 2> kToggle{"off", "on"};

ControlInfo coordinate(const char* symbol, const char* name, const char* group, float initial) {
    return {.symbol = symbol,
            .name = name,
            .least = -kFarthest_m,
            .greatest = kFarthest_m,
            .initial = initial,
            .unit = "m",
            .group = group};
}

ControlInfo room_share(const char* symbol, const char* name, const char* group) {
    return {.symbol = symbol,
            .name = name,
            .least = -1,
            .greatest = 1,
            .initial = 0,
            .group = group,
            .comment = "0: the place in metres; -1 and 1: the ends of the room."};
}

ControlInfo angle(const char* symbol, const char* name, const char* group, float greatest,
                  const char* comment) {
    return {.symbol = symbol,
            .name = name,
            .least = -greatest,
            .greatest = greatest,
            .initial = 0,
            .unit = "°",
            .group = group,
            .comment = comment};
}

ControlInfo toggle(const char* symbol, const char* name) {
    return {.symbol = symbol,
            .name = name,
            .least = 0,
            .greatest = 1,
            .initial = 1,
            .kind = ControlInfo::Kind::toggle,
            .group = "sound"};
}

/// Labels of the values of the control `room`.
std::vector<const char*> room_labels() {
    std::vector<const char*> labels{"scene file"};
    for (const ShippedRoom& room : shipped_rooms()) labels.push_back(room.name);
    return labels;
}

std::vector<ControlInfo> make_controls() {
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
        angle("listener_yaw", "Listener Yaw", "listener", 180,
              "Positive turns to the left; 0 looks along X."),
        angle("listener_pitch", "Listener Pitch", "listener", 90, "Positive looks up."),
        angle("listener_roll", "Listener Roll", "listener", 180, "Positive lowers the right ear."),
        {.symbol = "gain_db",
         .name = "Source Gain",
         .least = -60,
         .greatest = 24,
         .initial = 0,
         .unit = "dB",
         .group = "source"},
        toggle("direct", "Direct Sound"),
        toggle("early", "Early Reflections"),
        toggle("late", "Late Reverberation"),
        {.symbol = "wet",
         .name = "Wet",
         .least = 0,
         .greatest = 1,
         .initial = 1,
         .group = "sound",
         .comment = "1: the sound in the room; 0: the input."},
        {.symbol = "quality",
         .name = "Quality",
         .least = 0,
         .greatest = 2,
         .initial = 1,
         .kind = ControlInfo::Kind::enumeration,
         .scale_points = {"draft", "normal", "fine"},
         .comment = "Rays in each propagation frame: a quarter, as many as the scene says, or four "
                    "times as many."},
        {.symbol = "room_group",
         .name = "Room Group",
         .least = 0,
         .greatest = 16,
         .initial = 0,
         .kind = ControlInfo::Kind::integer,
         .comment = "Instances of one group share their room; 0: a separate room."},
        {.symbol = "enabled",
         .name = "Enabled",
         .least = 0,
         .greatest = 1,
         .initial = 1,
         .kind = ControlInfo::Kind::toggle},
        angle("source_yaw", "Source Yaw", "source", 180,
              "Turns the source to the left, and the two sources of a stereo input about their "
              "centre."),
        {.symbol = "room",
         .name = "Room",
         .least = 0,
         .greatest = static_cast<float>(shipped_rooms().size()),
         .initial = 0,
         .kind = ControlInfo::Kind::enumeration,
         .scale_points = room_labels(),
         .comment = "A room that ships with Aula, or the scene file of the state."},
        room_share("source_room_x", "Source in Room X (front)", "source"),
        room_share("source_room_y", "Source in Room Y (left)", "source"),
        room_share("source_room_z", "Source in Room Z (up)", "source"),
        room_share("listener_room_x", "Listener in Room X (front)", "listener"),
        room_share("listener_room_y", "Listener in Room Y (left)", "listener"),
        room_share("listener_room_z", "Listener in Room Z (up)", "listener"),
    };
}

}  // namespace

const std::vector<ControlInfo>& control_infos() {
    static const std::vector<ControlInfo> infos = make_controls();
    return infos;
}

float valid(Control control, float value) {
    const ControlInfo& info = control_infos()[static_cast<std::size_t>(control)];
    if (std::isnan(value)) return info.initial;
    return std::clamp(value, info.least, info.greatest);
}

std::string control_text(Control control, float value) {
    const ControlInfo& info = control_infos()[static_cast<std::size_t>(control)];
    using Kind = ControlInfo::Kind;
    const float shown = valid(control, value);
    const auto step = static_cast<std::size_t>(std::lround(shown - info.least));
    if (info.kind == Kind::toggle) return kToggle[step];
    if (info.kind == Kind::enumeration) return info.scale_points[step];
    std::string number =
        formatted(info.kind == Kind::integer ? "%.0f" : "%.2f", static_cast<double>(shown));
    std::replace(number.begin(), number.end(), ',', '.');  // of a host's locale
    return number;
}

std::optional<float> control_value(Control control, std::string_view text) {
    const ControlInfo& info = control_infos()[static_cast<std::size_t>(control)];
    const bool is_toggle = info.kind == ControlInfo::Kind::toggle;
    const std::span<const char* const> labels =
        is_toggle ? std::span<const char* const>(kToggle) : std::span(info.scale_points);
    for (std::size_t i = 0; i < labels.size(); ++i)
        if (text == labels[i]) return info.least + static_cast<float>(i);
    text.remove_prefix(std::min(text.find_first_not_of(" +"), text.size()));
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    return value;
}

}  // namespace aula::plugin
