#include "apps/plugin/vst3/vst3_plugin.h"

#include <algorithm>
#include <array>
#include <span>

namespace aula::plugin {

namespace {

/// A state is a few hundred bytes and two paths.
constexpr std::size_t kLongestState = 1 << 20;

/// Calls a function for each change of a parameter: its control, its sample and its value.
template <typename Function>
void for_each_change(v3_param_changes** changes, Function&& function) {
    if (changes == nullptr) return;
    const v3_param_changes& list = *v3_cpp_obj(changes);
    for (std::int32_t q = 0; q < list.get_param_count(changes); ++q) {
        v3_param_value_queue** const queue = list.get_param_data(changes, q);
        if (queue == nullptr) continue;
        const v3_param_value_queue& points = *v3_cpp_obj(queue);
        const v3_param_id id = points.get_param_id(queue);
        if (id >= kControls) continue;
        for (std::int32_t p = 0; p < points.get_point_count(queue); ++p) {
            std::int32_t sample = 0;
            double value = 0;
            if (points.get_point(queue, p, &sample, &value) == V3_OK)
                function(static_cast<Control>(id), sample, value);
        }
    }
}

bool has_bus(const v3_audio_bus_buffers* buses, std::int32_t count, std::size_t channels) {
    return count >= 1 && buses[0].num_channels >= static_cast<std::int32_t>(channels) &&
           buses[0].channel_buffers_32 != nullptr;
}

}  // namespace

double to_normalised(Control control, double value) {
    const ControlInfo& info = control_infos()[static_cast<std::size_t>(control)];
    const auto least = static_cast<double>(info.least);
    return std::clamp((value - least) / (static_cast<double>(info.greatest) - least), 0.0, 1.0);
}

double from_normalised(Control control, double normalised) {
    const ControlInfo& info = control_infos()[static_cast<std::size_t>(control)];
    const auto least = static_cast<double>(info.least);
    return least + normalised * (static_cast<double>(info.greatest) - least);
}

Vst3Plugin& vst3_plugin(void* self) { return *static_cast<Vst3Plugin::Interface*>(self)->plugin; }

Vst3Plugin::Vst3Plugin(const Kind& kind, const std::filesystem::path& folder)
    : component_{&kVst3Component, this},
      processor_{&kVst3Processor, this},
      controller_{&kVst3Controller, this},
      instance_(kind, folder) {}

Vst3Plugin::~Vst3Plugin() { set_handler(nullptr); }

v3_result Vst3Plugin::find_interface(const v3_tuid id, void** found) {
    *found = nullptr;
    if (v3_tuid_match(id, v3_funknown_iid) || v3_tuid_match(id, v3_plugin_base_iid) ||
        v3_tuid_match(id, v3_component_iid))
        *found = &component_;
    else if (v3_tuid_match(id, v3_audio_processor_iid))
        *found = &processor_;
    else if (v3_tuid_match(id, v3_edit_controller_iid))
        *found = &controller_;
    if (*found == nullptr) return V3_NO_INTERFACE;
    reference();
    return V3_OK;
}

std::uint32_t Vst3Plugin::release() {
    const std::uint32_t left = --references_;
    if (left == 0) delete this;
    return left;
}

v3_result Vst3Plugin::set_up(const v3_process_setup& setup) {
    if (instance_.is_active()) return V3_FALSE;
    if (setup.symbolic_sample_size != V3_SAMPLE_32) return V3_FALSE;
    sample_rate_hz_ = setup.sample_rate;
    longest_block_ = static_cast<std::uint32_t>(std::max(setup.max_block_size, 1));
    instance_.set_offline(setup.process_mode == V3_OFFLINE);
    return V3_OK;
}

v3_result Vst3Plugin::set_active(bool is_active) {
    if (is_active == instance_.is_active()) return V3_OK;
    if (is_active) return instance_.activate(sample_rate_hz_, longest_block_) ? V3_OK : V3_FALSE;
    instance_.deactivate();
    return V3_OK;
}

v3_result Vst3Plugin::save(v3_bstream** stream) const {
    std::string text = instance_.state();
    for (std::size_t done = 0; done < text.size();) {
        std::int32_t written = 0;
        const v3_result result = v3_cpp_obj(stream)->write(
            stream, text.data() + done, static_cast<std::int32_t>(text.size() - done), &written);
        if (result != V3_OK || written <= 0) return V3_FALSE;
        done += static_cast<std::size_t>(written);
    }
    return V3_OK;
}

v3_result Vst3Plugin::load(v3_bstream** stream) {
    std::string text;
    std::array<char, 4096> part;
    std::int32_t read = 0;
    while (v3_cpp_obj(stream)->read(stream, part.data(), part.size(), &read) == V3_OK && read > 0) {
        text.append(part.data(), std::min(static_cast<std::size_t>(read), part.size()));
        if (text.size() > kLongestState) return V3_FALSE;
    }
    if (!instance_.set_state(text)) return V3_FALSE;
    if (handler_ != nullptr)
        v3_cpp_obj(handler_)->restart_component(handler_, V3_RESTART_PARAM_VALUES_CHANGED);
    return V3_OK;
}

void Vst3Plugin::set_handler(v3_component_handler** handler) {
    if (handler != nullptr) v3_cpp_obj_ref(handler);
    if (handler_ != nullptr) v3_cpp_obj_unref(handler_);
    handler_ = handler;
}

/// Applies the changes at a sample, at 0 those before it as well. Returns the sample of the next
/// one, at most `end`.
std::int32_t Vst3Plugin::apply(v3_param_changes** changes, std::int32_t sample, std::int32_t end) {
    std::int32_t next = end;
    for_each_change(changes, [&](Control control, std::int32_t at, double value) {
        if (at > sample)
            next = std::min(next, at);
        else if (at == sample || sample == 0)
            instance_.set_parameter(control, from_normalised(control, value));
    });
    return next;
}

v3_result Vst3Plugin::process(const v3_process_data& block) {
    const std::size_t channels = channel_count(instance_.kind().output);
    const std::size_t sources = instance_.kind().sources;
    const std::int32_t samples = std::max(block.nframes, 0);
    const bool has_sound = samples > 0 && instance_.is_active() &&
                           block.symbolic_sample_size == V3_SAMPLE_32 &&
                           has_bus(block.inputs, block.num_input_buses, sources) &&
                           has_bus(block.outputs, block.num_output_buses, channels);
    if (!has_sound) {
        // A host may only hand over parameters.
        for_each_change(block.input_params, [&](Control control, std::int32_t, double value) {
            instance_.set_parameter(control, from_normalised(control, value));
        });
        return samples == 0 ? V3_OK : V3_FALSE;
    }
    const std::span<const float* const> inputs(block.inputs[0].channel_buffers_32, sources);
    const std::span<float* const> outputs(block.outputs[0].channel_buffers_32, channels);
    instance_.set_offline(block.process_mode == V3_OFFLINE);
    if (block.ctx != nullptr)
        instance_.begin_block(block.ctx->project_time_in_samples,
                              (block.ctx->state & V3_PROCESS_CTX_PLAYING) != 0);
    else
        instance_.begin_block(0, false);
    for (std::int32_t done = 0; done < samples;) {
        const std::int32_t next = apply(block.input_params, done, samples);
        instance_.process(inputs, outputs, static_cast<std::size_t>(done),
                          static_cast<std::size_t>(next));
        done = next;
    }
    // Those beyond the block, which a host should not give.
    for_each_change(block.input_params, [&](Control control, std::int32_t at, double value) {
        if (at >= samples) instance_.set_parameter(control, from_normalised(control, value));
    });
    block.outputs[0].channel_silence_bitset = 0;
    instance_.end_block();
    return V3_OK;
}

}  // namespace aula::plugin
