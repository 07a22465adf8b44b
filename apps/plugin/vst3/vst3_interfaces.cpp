// The functions of the interfaces of a VST3 plugin.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <span>
#include <string>
#include <string_view>

#include "apps/plugin/vst3/vst3_plugin.h"
#include "apps/plugin/vst3/vst3_view.h"

namespace aula::plugin {

namespace {

/// Speakers of VST3 that its C interface lacks: ambisonic channels 0 to 3 and 4 to 15.
constexpr v3_speaker_arrangement kFirstOrder = 0xFULL << 20;
constexpr v3_speaker_arrangement kThirdOrder = kFirstOrder | 0xFFFULL << 38;

v3_result query(void* self, const v3_tuid id, void** found) {
    return vst3_plugin(self).find_interface(id, found);
}
std::uint32_t reference(void* self) { return vst3_plugin(self).reference(); }
std::uint32_t release(void* self) { return vst3_plugin(self).release(); }
v3_result initialize(void*, v3_funknown**) { return V3_OK; }
v3_result terminate(void* self) {
    vst3_plugin(self).set_handler(nullptr);
    return V3_OK;
}

/// UTF-8 as UTF-16, cut to a text of VST3. All texts are of the basic plane.
void copy_text(std::string_view text, std::int16_t* to, std::size_t size = 128) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < text.size() && n + 1 < size; ++n) {
        const auto byte = static_cast<unsigned char>(text[i]);
        if (byte < 0x80) {
            to[n] = static_cast<std::int16_t>(byte);
            i += 1;
        } else {  // the sign of degrees
            const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
            to[n] = static_cast<std::int16_t>((byte & 0x1F) << 6 | (next & 0x3F));
            i += 2;
        }
    }
    to[n] = 0;
}

std::size_t channels_of(void* self, std::int32_t direction) {
    const Kind& kind = vst3_plugin(self).instance().kind();
    return direction == V3_INPUT ? kind.sources : channel_count(kind.output);
}

v3_speaker_arrangement arrangement(void* self, std::int32_t direction) {
    switch (channels_of(self, direction)) {
        case 1:
            return V3_SPEAKER_M;
        case 2:
            return V3_SPEAKER_L | V3_SPEAKER_R;
        case 4:
            return kFirstOrder;
        default:
            return kThirdOrder;
    }
}

// --- component

v3_result controller_class(void*, v3_tuid) { return V3_NOT_IMPLEMENTED; }
v3_result set_io_mode(void*, std::int32_t) { return V3_NOT_IMPLEMENTED; }
std::int32_t bus_count(void*, std::int32_t type, std::int32_t) { return type == V3_AUDIO ? 1 : 0; }

v3_result bus_info(void* self, std::int32_t type, std::int32_t direction, std::int32_t index,
                   v3_bus_info* info) {
    if (type != V3_AUDIO || index != 0) return V3_INVALID_ARG;
    *info = {.media_type = V3_AUDIO,
             .direction = direction,
             .channel_count = static_cast<std::int32_t>(channels_of(self, direction)),
             .bus_name = {},
             .bus_type = V3_MAIN,
             .flags = V3_DEFAULT_ACTIVE};
    copy_text(direction == V3_INPUT ? "Input" : "Output", info->bus_name);
    return V3_OK;
}

v3_result routing(void*, v3_routing_info*, v3_routing_info*) { return V3_NOT_IMPLEMENTED; }
v3_result activate_bus(void*, std::int32_t type, std::int32_t, std::int32_t index, v3_bool) {
    return type == V3_AUDIO && index == 0 ? V3_OK : V3_INVALID_ARG;
}
v3_result set_active(void* self, v3_bool is_active) {
    return vst3_plugin(self).set_active(is_active != 0);
}
v3_result set_state(void* self, v3_bstream** stream) { return vst3_plugin(self).load(stream); }
v3_result get_state(void* self, v3_bstream** stream) { return vst3_plugin(self).save(stream); }

// --- processor

/// Kinds have fixed arrangements.
v3_result set_arrangements(void* self, v3_speaker_arrangement* inputs, std::int32_t input_count,
                           v3_speaker_arrangement* outputs, std::int32_t output_count) {
    const bool same = input_count == 1 && output_count == 1 &&
                      inputs[0] == arrangement(self, V3_INPUT) &&
                      outputs[0] == arrangement(self, V3_OUTPUT);
    return same ? V3_TRUE : V3_FALSE;
}

v3_result get_arrangement(void* self, std::int32_t direction, std::int32_t index,
                          v3_speaker_arrangement* found) {
    if (index != 0) return V3_INVALID_ARG;
    *found = arrangement(self, direction);
    return V3_OK;
}

v3_result can_process(void*, std::int32_t size) {
    return size == V3_SAMPLE_32 ? V3_TRUE : V3_FALSE;
}
std::uint32_t latency(void*) { return 0; }
v3_result set_up(void* self, v3_process_setup* setup) { return vst3_plugin(self).set_up(*setup); }
v3_result set_processing(void*, v3_bool) { return V3_OK; }
v3_result process(void* self, v3_process_data* block) { return vst3_plugin(self).process(*block); }
std::uint32_t tail(void* self) { return vst3_plugin(self).instance().tail_samples(); }

// --- controller

/// The component is this object, too.
v3_result set_component_state(void*, v3_bstream**) { return V3_OK; }
v3_result set_controller_state(void*, v3_bstream**) { return V3_OK; }
v3_result get_controller_state(void*, v3_bstream**) { return V3_OK; }
std::int32_t parameter_count(void*) { return kControls; }

v3_result parameter_info(void*, std::int32_t index, v3_param_info* info) {
    if (index < 0 || static_cast<std::size_t>(index) >= kControls) return V3_INVALID_ARG;
    const ControlInfo& about = control_infos()[static_cast<std::size_t>(index)];
    const auto control = static_cast<Control>(index);
    const bool is_bypass = control == Control::enabled;
    const bool has_steps = about.kind != ControlInfo::Kind::number;
    const double initial = is_bypass ? 0 : static_cast<double>(about.initial);
    int flags = V3_PARAM_CAN_AUTOMATE;
    if (about.kind == ControlInfo::Kind::enumeration) flags |= V3_PARAM_IS_LIST;
    if (is_bypass) flags |= V3_PARAM_IS_BYPASS;
    *info = {.param_id = static_cast<v3_param_id>(index),
             .title = {},
             .short_title = {},
             .units = {},
             .step_count = has_steps ? static_cast<std::int32_t>(about.greatest - about.least) : 0,
             .default_normalised_value = to_normalised(control, initial),
             .unit_id = 0,
             .flags = flags};
    const char* const name = is_bypass ? "Bypass" : about.name;
    copy_text(name, info->title);
    copy_text(name, info->short_title);
    copy_text(about.unit, info->units);
    return V3_OK;
}

v3_result text_of_value(void*, v3_param_id id, double normalised, v3_str_128 text) {
    if (id >= kControls) return V3_INVALID_ARG;
    const auto control = static_cast<Control>(id);
    copy_text(control_text(control, static_cast<float>(from_normalised(control, normalised))),
              text);
    return V3_OK;
}

v3_result value_of_text(void*, v3_param_id id, std::int16_t* text, double* normalised) {
    if (id >= kControls) return V3_INVALID_ARG;
    std::string ascii;
    for (; *text != 0 && ascii.size() < 128; ++text)
        ascii += *text > 0 && *text < 0x80 ? static_cast<char>(*text) : '?';
    const auto control = static_cast<Control>(id);
    const auto value = control_value(control, ascii);
    if (!value) return V3_FALSE;
    *normalised = to_normalised(control, static_cast<double>(*value));
    return V3_OK;
}

double to_plain(void*, v3_param_id id, double normalised) {
    return id < kControls ? from_normalised(static_cast<Control>(id), normalised) : normalised;
}
double from_plain(void*, v3_param_id id, double plain) {
    return id < kControls ? to_normalised(static_cast<Control>(id), plain) : plain;
}

double get_parameter(void* self, v3_param_id id) {
    if (id >= kControls) return 0;
    const auto control = static_cast<Control>(id);
    return to_normalised(control, vst3_plugin(self).instance().parameter(control));
}

v3_result set_parameter(void* self, v3_param_id id, double normalised) {
    if (id >= kControls || std::isnan(normalised)) return V3_INVALID_ARG;
    const auto control = static_cast<Control>(id);
    vst3_plugin(self).instance().set_parameter(control, from_normalised(control, normalised));
    return V3_OK;
}

v3_result set_handler(void* self, v3_component_handler** handler) {
    vst3_plugin(self).set_handler(handler);
    return V3_OK;
}

v3_plugin_view** create_view(void* self, const char* name) {
    if (!PluginEditor::is_built() || std::strcmp(name, "editor") != 0) return nullptr;
    try {
        return (new Vst3View(vst3_plugin(self)))->view();
    } catch (const std::exception&) {
        return nullptr;
    }
}

}  // namespace

const v3_component_cpp kVst3Component{{query, reference, release},
                                      {initialize, terminate},
                                      {controller_class, set_io_mode, bus_count, bus_info, routing,
                                       activate_bus, set_active, set_state, get_state}};

const v3_audio_processor_cpp kVst3Processor{{query, reference, release},
                                            {set_arrangements, get_arrangement, can_process,
                                             latency, set_up, set_processing, process, tail}};

const v3_edit_controller_cpp kVst3Controller{
    {query, reference, release},
    {initialize, terminate},
    {set_component_state, set_controller_state, get_controller_state, parameter_count,
     parameter_info, text_of_value, value_of_text, to_plain, from_plain, get_parameter,
     set_parameter, set_handler, create_view}};

}  // namespace aula::plugin
