#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "aula/audio/output_format.h"

namespace aula::plugin {

// The ports of the plugins, in their order: the audio input, the outputs, the controls, the two
// event ports. Hosts store ports by index and values by symbol: neither changes; new ports come
// last.

/// URI of the bundle's plugins without their layout; properties have it as a prefix, too.
#define AULA_PLUGIN_URI "urn:aula:room"

/// A plugin of the bundle: its layout of outputs.
struct Layout {
    const char* uri;
    const char* name;
    OutputFormat output;
};

inline constexpr std::array<Layout, 3> kLayouts{
    Layout{AULA_PLUGIN_URI "#binaural", "Aula Room (binaural)", OutputFormat::binaural},
    Layout{AULA_PLUGIN_URI "#foa", "Aula Room (ambisonics, first order)", OutputFormat::foa},
    Layout{AULA_PLUGIN_URI "#toa", "Aula Room (ambisonics, third order)", OutputFormat::toa}};

/// The control ports; the value is the index after the audio ports.
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
    freewheel,
    latency
};

inline constexpr std::size_t kControls = static_cast<std::size_t>(Control::latency) + 1;

/// Values of all control ports, by Control.
using ControlValues = std::array<float, kControls>;

/// The value of a control.
inline float value_of(const ControlValues& values, Control control) {
    return values[static_cast<std::size_t>(control)];
}

/// What a host has to know about a control port.
struct ControlPort {
    enum class Kind { number, toggle, enumeration, integer };

    const char* symbol;
    const char* name;
    float least;
    float greatest;
    float initial;
    Kind kind = Kind::number;
    const char* unit = "";                    ///< of the vocabulary units, or empty
    const char* group = "";                   ///< symbol of the group of ports, or empty
    const char* designation = "";             ///< with its prefix, or empty
    std::vector<const char*> scale_points{};  ///< labels of the values from `least` on
    const char* comment = "";
    bool output = false;
};

/// All control ports, by Control. Initial places are those of the default room.
const std::vector<ControlPort>& control_ports();

/// A value within its port's range; the initial value if it is not a number.
float valid(Control control, float value);

/// Indices of the ports of a layout.
inline constexpr std::uint32_t kInputPort = 0;
inline std::uint32_t control_port(OutputFormat output, std::size_t control) {
    return static_cast<std::uint32_t>(1 + channel_count(output) + control);
}

}  // namespace aula::plugin
