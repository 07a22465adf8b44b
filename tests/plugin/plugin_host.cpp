#include "tests/plugin/plugin_host.h"

#include <dlfcn.h>
#include <lv2/atom/util.h>
#include <lv2/patch/patch.h>
#include <lv2/time/time.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace aula::test {

namespace {

const LV2_Descriptor* find_descriptor(OutputFormat layout) {
    void* const library = dlopen(AULA_PLUGIN_BINARY, RTLD_NOW);
    if (library == nullptr) throw std::runtime_error(dlerror());
    const auto get = reinterpret_cast<LV2_Descriptor_Function>(dlsym(library, "lv2_descriptor"));
    demand(get != nullptr, "no lv2_descriptor");
    for (std::size_t i = 0; i < plugin::kLayouts.size(); ++i)
        if (plugin::kLayouts[i].output == layout) return get(static_cast<std::uint32_t>(i));
    return nullptr;
}

}  // namespace

LV2_URID PluginHost::map_uri(LV2_URID_Map_Handle handle, const char* uri) {
    return static_cast<PluginHost*>(handle)->urid(uri);
}

LV2_URID PluginHost::urid(const std::string& uri) const {
    const auto at = std::find(uris_.begin(), uris_.end(), uri);
    if (at != uris_.end()) return static_cast<LV2_URID>(at - uris_.begin() + 1);
    uris_.push_back(uri);
    return static_cast<LV2_URID>(uris_.size());
}

PluginHost::PluginHost(OutputFormat layout, double rate_hz)
    : layout_(layout), map_{this, map_uri}, descriptor_(find_descriptor(layout)) {
    for (std::size_t i = 0; i < plugin::kControls; ++i)
        controls_[i] = plugin::control_infos()[i].initial;
    const LV2_Feature map{LV2_URID__map, &map_};
    const std::array<const LV2_Feature*, 2> features{&map, nullptr};
    handle_ = descriptor_->instantiate(descriptor_, rate_hz, "", features.data());
    demand(handle_ != nullptr, "no instance");
    for (std::size_t i = 0; i < plugin::kControls; ++i)
        descriptor_->connect_port(handle_, plugin::control_port(layout, i), &controls_[i]);
    descriptor_->connect_port(handle_, plugin::freewheel_port(layout), &freewheel_);
    descriptor_->connect_port(handle_, plugin::latency_port(layout), &latency_);
    descriptor_->connect_port(handle_, plugin::level_port(layout), &level_db_);
    descriptor_->connect_port(handle_, plugin::messages_port(layout), control_.data());
    descriptor_->connect_port(handle_, plugin::notify_port(layout), notify_.data());
    lv2_atom_forge_init(&forge_, &map_);
    lv2_atom_forge_set_buffer(&forge_, control_.data(), control_.size());
    lv2_atom_forge_sequence_head(&forge_, &sequence_, 0);
}

PluginHost::~PluginHost() {
    if (active_) deactivate();
    descriptor_->cleanup(handle_);
}

void PluginHost::activate() {
    descriptor_->activate(handle_);
    active_ = true;
}

void PluginHost::deactivate() {
    descriptor_->deactivate(handle_);
    active_ = false;
}

void PluginHost::send_path(const std::string& property, const std::string& path) {
    LV2_Atom_Forge_Frame object;
    lv2_atom_forge_frame_time(&forge_, 0);
    lv2_atom_forge_object(&forge_, &object, 0, urid(LV2_PATCH__Set));
    lv2_atom_forge_key(&forge_, urid(LV2_PATCH__property));
    lv2_atom_forge_urid(&forge_, urid(property));
    lv2_atom_forge_key(&forge_, urid(LV2_PATCH__value));
    lv2_atom_forge_path(&forge_, path.c_str(), static_cast<std::uint32_t>(path.size()));
    lv2_atom_forge_pop(&forge_, &object);
}

void PluginHost::send_get() {
    LV2_Atom_Forge_Frame object;
    lv2_atom_forge_frame_time(&forge_, 0);
    lv2_atom_forge_object(&forge_, &object, 0, urid(LV2_PATCH__Get));
    lv2_atom_forge_pop(&forge_, &object);
}

void PluginHost::send_position(std::int64_t frame, float speed) {
    LV2_Atom_Forge_Frame object;
    lv2_atom_forge_frame_time(&forge_, 0);
    lv2_atom_forge_object(&forge_, &object, 0, urid(LV2_TIME__Position));
    lv2_atom_forge_key(&forge_, urid(LV2_TIME__frame));
    lv2_atom_forge_long(&forge_, frame);
    lv2_atom_forge_key(&forge_, urid(LV2_TIME__speed));
    lv2_atom_forge_float(&forge_, speed);
    lv2_atom_forge_pop(&forge_, &object);
}

Channels PluginHost::run(std::span<const float> input, const std::vector<std::size_t>& sizes) {
    Channels output(channel_count(layout_));
    std::size_t call = 0;
    for (std::size_t done = 0; done < input.size();) {
        const std::size_t samples = std::min(sizes[call++ % sizes.size()], input.size() - done);
        run_block(input.data() + done, samples, output);
        done += samples;
    }
    return output;
}

void PluginHost::run_block(const float* input, std::size_t samples, Channels& output) {
    const std::size_t done = output[0].size();
    for (std::vector<float>& channel : output) channel.resize(done + samples);
    std::copy_n(input, samples, output[0].begin() + static_cast<std::ptrdiff_t>(done));
    descriptor_->connect_port(handle_, plugin::kInputPort, output[0].data() + done);
    for (std::size_t c = 0; c < output.size(); ++c)
        descriptor_->connect_port(handle_, static_cast<std::uint32_t>(1 + c),
                                  output[c].data() + done);
    lv2_atom_forge_pop(&forge_, &sequence_);
    auto* const notify = reinterpret_cast<LV2_Atom_Sequence*>(notify_.data());
    notify->atom = {static_cast<std::uint32_t>(notify_.size() - sizeof(LV2_Atom)), 0};
    if (violations_ == nullptr) {
        descriptor_->run(handle_, static_cast<std::uint32_t>(samples));
    } else {
        const RealtimeTrap trap;
        descriptor_->run(handle_, static_cast<std::uint32_t>(samples));
        *violations_ += trap.violations();
    }
    lv2_atom_forge_set_buffer(&forge_, control_.data(), control_.size());
    lv2_atom_forge_sequence_head(&forge_, &sequence_, 0);
    receive();
}

void PluginHost::receive() {
    const auto* const notify = reinterpret_cast<const LV2_Atom_Sequence*>(notify_.data());
    LV2_ATOM_SEQUENCE_FOREACH(notify, event) {
        const auto* const object = reinterpret_cast<const LV2_Atom_Object*>(&event->body);
        const LV2_Atom* property = nullptr;
        const LV2_Atom* value = nullptr;
        lv2_atom_object_get(object, urid(LV2_PATCH__property), &property, urid(LV2_PATCH__value),
                            &value, 0);
        demand(property != nullptr && value != nullptr, "a message without property or value");
        const LV2_URID name = reinterpret_cast<const LV2_Atom_URID*>(property)->body;
        received_[uris_[name - 1]] = static_cast<const char*>(LV2_ATOM_BODY_CONST(value));
    }
}

std::string PluginHost::received(const std::string& property) const {
    const auto at = received_.find(property);
    return at == received_.end() ? "-" : at->second;
}

namespace {

const LV2_State_Interface* state_of(const LV2_Descriptor& descriptor) {
    return static_cast<const LV2_State_Interface*>(descriptor.extension_data(LV2_STATE__interface));
}

}  // namespace

StoredState PluginHost::save() const {
    struct Store {
        const PluginHost* host;
        StoredState state;
    } stored{this, {}};
    const auto store = [](LV2_State_Handle handle, std::uint32_t key, const void* value,
                          std::size_t size, std::uint32_t type, std::uint32_t) {
        auto& to = *static_cast<Store*>(handle);
        const auto* const bytes = static_cast<const char*>(value);
        to.state[to.host->uris_[key - 1]] = {to.host->uris_[type - 1], {bytes, bytes + size}};
        return LV2_STATE_SUCCESS;
    };
    const std::array<const LV2_Feature*, 1> features{nullptr};
    demand(state_of(*descriptor_)->save(handle_, store, &stored, 0, features.data()) ==
               LV2_STATE_SUCCESS,
           "the state cannot be saved");
    return stored.state;
}

void PluginHost::restore(const StoredState& state) {
    struct Source {
        const PluginHost* host;
        const StoredState* state;
    } source{this, &state};
    const auto retrieve = [](LV2_State_Handle handle, std::uint32_t key, std::size_t* size,
                             std::uint32_t* type, std::uint32_t* flags) -> const void* {
        const auto& from = *static_cast<const Source*>(handle);
        const auto at = from.state->find(from.host->uris_[key - 1]);
        if (at == from.state->end()) return nullptr;
        *size = at->second.second.size();
        *type = from.host->urid(at->second.first);
        *flags = LV2_STATE_IS_POD;
        return at->second.second.data();
    };
    const std::array<const LV2_Feature*, 1> features{nullptr};
    demand(state_of(*descriptor_)->restore(handle_, retrieve, &source, 0, features.data()) ==
               LV2_STATE_SUCCESS,
           "the state cannot be restored");
}

}  // namespace aula::test
