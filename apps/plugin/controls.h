#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "aula/audio/output_format.h"

namespace aula::plugin {

/// A plugin: its inputs and its layout of outputs.
struct Kind {
    const char* id;  ///< of CLAP, and the name of the VST3 class; hosts store it
    const char* name;
    OutputFormat output;
    std::size_t sources;  ///< inputs
};

/// Formats store the order: new kinds come last.
inline constexpr std::array<Kind, 6> kKinds{
    Kind{"aula.room.binaural", "Aula Room (binaural)", OutputFormat::binaural, 1},
    Kind{"aula.room.foa", "Aula Room (ambisonics, first order)", OutputFormat::foa, 1},
    Kind{"aula.room.toa", "Aula Room (ambisonics, third order)", OutputFormat::toa, 1},
    Kind{"aula.room.stereo.binaural", "Aula Room, stereo input (binaural)", OutputFormat::binaural,
         2},
    Kind{"aula.room.stereo.foa", "Aula Room, stereo input (ambisonics, first order)",
         OutputFormat::foa, 2},
    Kind{"aula.room.stereo.toa", "Aula Room, stereo input (ambisonics, third order)",
         OutputFormat::toa, 2}};

/// What a host controls. Hosts store the number or the symbol of a control: neither changes, and
/// new controls come last.
enum class Control : std::size_t {
    source_x,
    source_y,
    source_z,
    listener_x,
    listener_y,
    listener_z,
    listener_yaw,
    listener_pitch,
    listener_roll,
    gain_db,
    direct,
    early,
    late,
    wet,
    quality,
    room_group,
    enabled,
    source_yaw,
    room,
    source_room_x,
    source_room_y,
    source_room_z,
    listener_room_x,
    listener_room_y,
    listener_room_z
};

inline constexpr std::size_t kControls = static_cast<std::size_t>(Control::listener_room_z) + 1;

/// Values of all controls, by Control.
using ControlValues = std::array<float, kControls>;

/// The value of a control.
inline float value_of(const ControlValues& values, Control control) {
    return values[static_cast<std::size_t>(control)];
}

/// What a host has to know about a control.
struct ControlInfo {
    enum class Kind { number, toggle, enumeration, integer };

    const char* symbol;
    const char* name;
    float least;
    float greatest;
    float initial;
    Kind kind = Kind::number;
    const char* unit = "";                    ///< symbol, or empty
    const char* group = "";                   ///< "source", "listener", "sound", or empty
    std::vector<const char*> scale_points{};  ///< labels of the values from `least` on
    const char* comment = "";
};

/// All controls, by Control. Initial places are those of the default room.
const std::vector<ControlInfo>& control_infos();

/// A value within its control's range; the initial value if it is not a number.
float valid(Control control, float value);

/// A value as a user reads it, without its unit.
std::string control_text(Control control, float value);

/// The value of what a user writes: a label or a number, with or without the unit; none if it is
/// neither. It may be invalid.
std::optional<float> control_value(Control control, std::string_view text);

}  // namespace aula::plugin
