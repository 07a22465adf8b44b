// The extensions of the CLAP plugins: ports, parameters, state, rendering offline, latency, tail.

#include <clap/ext/audio-ports.h>
#include <clap/ext/latency.h>
#include <clap/ext/params.h>
#include <clap/ext/state.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "apps/plugin/clap/clap_plugin.h"

namespace aula::plugin {

namespace {

/// Text cut to a buffer, which ends with a zero.
void copy_text(std::string_view text, std::span<char> to) {
    const std::size_t size = std::min(text.size(), to.size() - 1);
    std::copy_n(text.begin(), size, to.begin());
    to[size] = 0;
}

std::uint32_t port_count(const clap_plugin_t*, bool) { return 1; }

bool port(const clap_plugin_t* plugin, std::uint32_t index, bool is_input,
          clap_audio_port_info_t* info) {
    if (index != 0) return false;
    const Kind& kind = ClapPlugin::of(plugin).instance().kind();
    const std::size_t channels = is_input ? kind.sources : channel_count(kind.output);
    const bool is_field = !is_input && kind.output != OutputFormat::binaural;
    *info = {.id = is_input ? 0U : 1U,
             .name = {},
             .flags = CLAP_AUDIO_PORT_IS_MAIN,
             .channel_count = static_cast<std::uint32_t>(channels),
             .port_type = is_field        ? kAmbisonicPort
                          : channels == 1 ? CLAP_PORT_MONO
                                          : CLAP_PORT_STEREO,
             .in_place_pair = CLAP_INVALID_ID};
    copy_text(is_input ? "Input" : "Output", info->name);
    return true;
}

bool is_supported(const clap_plugin_t*, const AmbisonicConfig* config) {
    return config->ordering == AmbisonicConfig::kAcn &&
           config->normalization == AmbisonicConfig::kSn3d;
}

bool ambisonics(const clap_plugin_t* plugin, bool is_input, std::uint32_t index,
                AmbisonicConfig* config) {
    if (is_input || index != 0 ||
        ClapPlugin::of(plugin).instance().kind().output == OutputFormat::binaural)
        return false;
    *config = {AmbisonicConfig::kAcn, AmbisonicConfig::kSn3d};
    return true;
}

std::uint32_t parameter_count(const clap_plugin_t*) { return kControls; }

bool parameter_info(const clap_plugin_t*, std::uint32_t index, clap_param_info_t* info) {
    if (index >= kControls) return false;
    const auto control = static_cast<Control>(index);
    const ControlInfo& about = control_infos()[index];
    const bool is_bypass = control == Control::enabled;
    clap_param_info_flags flags = CLAP_PARAM_IS_AUTOMATABLE;
    if (about.kind != ControlInfo::Kind::number) flags |= CLAP_PARAM_IS_STEPPED;
    if (is_bypass) flags |= CLAP_PARAM_IS_BYPASS;
    *info = {.id = static_cast<clap_id>(index),
             .flags = flags,
             .cookie = nullptr,
             .name = {},
             .module = {},
             .min_value = static_cast<double>(about.least),
             .max_value = static_cast<double>(about.greatest),
             .default_value = is_bypass ? 0 : static_cast<double>(about.initial)};
    copy_text(is_bypass ? "Bypass" : about.name, info->name);
    copy_text(about.group, info->module);
    return true;
}

bool parameter_value(const clap_plugin_t* plugin, clap_id id, double* value) {
    if (id >= kControls) return false;
    *value = ClapPlugin::of(plugin).instance().parameter(static_cast<Control>(id));
    return true;
}

bool value_to_text(const clap_plugin_t*, clap_id id, double value, char* text, std::uint32_t size) {
    if (id >= kControls || size == 0) return false;
    std::string shown = control_text(static_cast<Control>(id), static_cast<float>(value));
    if (const char* const unit = control_infos()[id].unit; *unit != 0)
        shown += std::string(" ") + unit;
    copy_text(shown, {text, size});
    return true;
}

bool text_to_value(const clap_plugin_t*, clap_id id, const char* text, double* value) {
    if (id >= kControls) return false;
    const auto read = control_value(static_cast<Control>(id), text);
    if (read) *value = static_cast<double>(valid(static_cast<Control>(id), *read));
    return read.has_value();
}

void flush(const clap_plugin_t* plugin, const clap_input_events_t* in,
           const clap_output_events_t* out) {
    ClapPlugin::of(plugin).flush(in, out);
}

constexpr clap_plugin_audio_ports_t kPorts{port_count, port};
constexpr AmbisonicExtension kAmbisonics{is_supported, ambisonics};
constexpr clap_plugin_params_t kParameters{parameter_count, parameter_info, parameter_value,
                                           value_to_text,   text_to_value,  flush};
constexpr clap_plugin_state_t kState{[](const clap_plugin_t* plugin, const clap_ostream_t* stream) {
                                         return ClapPlugin::of(plugin).save(*stream);
                                     },
                                     [](const clap_plugin_t* plugin, const clap_istream_t* stream) {
                                         return ClapPlugin::of(plugin).load(*stream);
                                     }};
constexpr RenderExtension kRender{
    [](const clap_plugin_t*) { return false; },
    [](const clap_plugin_t* plugin, std::int32_t mode) {
        ClapPlugin::of(plugin).instance().set_offline(mode == RenderExtension::offline);
        return true;
    }};
constexpr clap_plugin_latency_t kLatency{[](const clap_plugin_t*) -> std::uint32_t { return 0; }};
constexpr TailExtension kTail{
    [](const clap_plugin_t* plugin) { return ClapPlugin::of(plugin).instance().tail_samples(); }};

constexpr std::array<std::pair<const char*, const void*>, 8> kExtensions{
    {{CLAP_EXT_AUDIO_PORTS, &kPorts},
     {kAmbisonicExtension, &kAmbisonics},
     {kAmbisonicDraft, &kAmbisonics},
     {CLAP_EXT_PARAMS, &kParameters},
     {CLAP_EXT_STATE, &kState},
     {kRenderExtension, &kRender},
     {CLAP_EXT_LATENCY, &kLatency},
     {kTailExtension, &kTail}}};

}  // namespace

const void* find_extension(const char* id) {
    for (const auto& [name, extension] : kExtensions)
        if (std::strcmp(name, id) == 0) return extension;
    return find_editor_extension(id);
}

}  // namespace aula::plugin
