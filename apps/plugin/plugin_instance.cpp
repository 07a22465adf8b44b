#include "apps/plugin/plugin_instance.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <exception>
#include <limits>
#include <utility>

#include "apps/room/base/output_resources.h"

namespace aula::plugin {

PluginInstance::PluginInstance(const Kind& kind, std::filesystem::path folder)
    : kind_(kind), folder_(std::move(folder)) {
    const ControlValues initial = initial_values();
    std::copy(initial.begin(), initial.end(), values_.begin());
}

bool PluginInstance::activate(double sample_rate_hz, std::uint32_t longest_block) {
    if (plugin_) return false;
    constexpr std::uint32_t kLeast = 32;
    constexpr std::uint32_t kMost = 1024;
    const int block = static_cast<int>(std::bit_floor(std::clamp(longest_block, kLeast, kMost)));
    try {
        PluginPorts ports{
            {.sample_rate_hz = sample_rate_hz, .block = block, .output = kind_.output}};
        ports.sources = kind_.sources;
        ports.folder = folder_;
        check_output(ports, "plugin");
        auto plugin = std::make_unique<RoomPlugin>(ports);
        plugin->set_files(files_);
        plugin->activate(values(), is_offline_);
        plugin_ = std::move(plugin);
    } catch (const std::exception&) {
        return false;
    }
    rolls_ = false;
    return true;
}

void PluginInstance::deactivate() {
    if (!plugin_) return;
    files_ = plugin_->files();
    plugin_->deactivate();
    plugin_.reset();
}

std::string PluginInstance::state() const {
    return write_state({.files = files(), .controls = values(), .read_from = read_from_});
}

bool PluginInstance::set_state(std::string_view text) {
    auto state = read_state(text);
    if (!state) return false;
    std::copy(state->controls.begin(), state->controls.end(), values_.begin());
    read_from_ = std::move(state->read_from);
    files_ = state->files;
    if (plugin_) plugin_->set_files(files_);
    return true;
}

std::string PluginInstance::new_status() {
    std::string status = this->status();
    return std::exchange(reported_, status) == status ? std::string() : status;
}

void PluginInstance::choose_scene(const std::filesystem::path& file) {
    files_ = files();
    files_.scene = file;
    if (plugin_) plugin_->change_files(files_);
}

ControlValues PluginInstance::values() const {
    ControlValues values;
    for (std::size_t i = 0; i < kControls; ++i) values[i] = values_[i];
    return values;
}

double PluginInstance::parameter(Control control) const {
    const float value = values_[static_cast<std::size_t>(control)];
    return static_cast<double>(control == Control::enabled ? 1 - value : value);
}

void PluginInstance::set_parameter(Control control, double value) {
    const auto number = static_cast<float>(value);
    values_[static_cast<std::size_t>(control)] =
        valid(control, control == Control::enabled ? 1 - number : number);
}

std::uint32_t PluginInstance::tail_samples() const {
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max() - 1;  // not infinite
    return plugin_ ? static_cast<std::uint32_t>(std::min(plugin_->tail_samples(), kMost)) : 0;
}

void PluginInstance::begin_block(std::int64_t transport, bool rolls) {
    if (!rolls || !rolls_ || std::abs(transport - transport_) > 1) transport_ = transport;
    rolls_ = rolls;
    plugin_->set_offline(is_offline_);
    plugin_->set_controls(values());
    plugin_->move_transport(transport_, rolls_);
}

void PluginInstance::process(std::span<const float* const> inputs, std::span<float* const> outputs,
                             std::size_t first, std::size_t last) {
    plugin_->set_controls(values());
    plugin_->process(inputs, outputs, first, last);
    if (rolls_) transport_ += static_cast<std::int64_t>(last - first);
}

bool PluginInstance::end_block() {
    MessageQueue& replies = plugin_->replies();
    const bool has_some = replies.front() != nullptr;
    while (replies.front() != nullptr) replies.pop();
    return has_some;
}

}  // namespace aula::plugin
