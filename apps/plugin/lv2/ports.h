#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "apps/plugin/controls.h"
#include "apps/plugin/message_queue.h"

namespace aula::plugin {

// The ports of the LV2 plugins, in their order: the audio input, the outputs, the controls from
// source_x to enabled, freewheel, latency, the two event ports, the other controls, level. Hosts
// store ports by index and values by symbol: neither changes; new ports come last.

/// URI of the bundle's plugins without their layout; properties have it as a prefix, too.
#define AULA_PLUGIN_URI "urn:aula:room"

/// LV2 has the kinds with one input.
inline constexpr std::span<const Kind, 3> kLayouts = std::span(kKinds).first<3>();

/// URIs of the plugins, by the index of their layout.
inline constexpr std::array<const char*, kLayouts.size()> kPluginUris{
    AULA_PLUGIN_URI "#binaural", AULA_PLUGIN_URI "#foa", AULA_PLUGIN_URI "#toa"};

inline constexpr std::uint32_t kInputPort = 0;

/// Controls before the other ports, and the number of the ports between them and later ones.
inline constexpr std::size_t kFirstControls = static_cast<std::size_t>(Control::enabled) + 1;
inline constexpr std::uint32_t kPortsBetween = 4;

/// Indices of the ports of a layout.
inline std::uint32_t control_port(OutputFormat output, std::size_t control) {
    const std::uint32_t between = control < kFirstControls ? 0 : kPortsBetween;
    return static_cast<std::uint32_t>(1 + channel_count(output) + control + between);
}
inline std::uint32_t freewheel_port(OutputFormat output) {
    return control_port(output, kFirstControls) - kPortsBetween;
}
inline std::uint32_t latency_port(OutputFormat output) { return freewheel_port(output) + 1; }
inline std::uint32_t messages_port(OutputFormat output) { return freewheel_port(output) + 2; }
inline std::uint32_t notify_port(OutputFormat output) { return freewheel_port(output) + 3; }
/// An output. Later controls come after it.
inline std::uint32_t level_port(OutputFormat output) { return control_port(output, kControls); }

/// URIs of properties, by Property.
inline constexpr std::array<const char*, kProperties> kPropertyUris{
    AULA_PLUGIN_URI "#scene", AULA_PLUGIN_URI "#hrtf", AULA_PLUGIN_URI "#status"};

/// URI of the editor.
inline constexpr const char* kEditorUri = AULA_PLUGIN_URI "#editor";

}  // namespace aula::plugin
