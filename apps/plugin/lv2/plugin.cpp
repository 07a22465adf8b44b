// The entry point of the bundle and its descriptors.

#include <lv2/atom/atom.h>
#include <lv2/buf-size/buf-size.h>
#include <lv2/core/lv2.h>
#include <lv2/options/options.h>
#include <lv2/state/state.h>
#include <lv2/urid/urid.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <exception>

#include "apps/plugin/lv2/features.h"
#include "apps/plugin/lv2/lv2_plugin.h"
#include "apps/plugin/lv2/ports.h"
#include "apps/room/base/output_resources.h"

namespace {

using namespace aula::plugin;

/// The size of most blocks: what the host says, or 256.
int block_size(const LV2_Feature* const* features, const LV2_URID_Map* map) {
    constexpr int kDefault = 256;
    const auto* option =
        static_cast<const LV2_Options_Option*>(find_feature(features, LV2_OPTIONS__options));
    if (map == nullptr || option == nullptr) return kDefault;
    const LV2_URID nominal = map->map(map->handle, LV2_BUF_SIZE__nominalBlockLength);
    const LV2_URID integer = map->map(map->handle, LV2_ATOM__Int);
    for (; option->key != 0; ++option) {
        if (option->key != nominal || option->type != integer || option->value == nullptr) continue;
        std::int32_t samples = 0;
        std::memcpy(&samples, option->value, sizeof samples);
        constexpr std::uint32_t kLeast = 32;
        constexpr std::uint32_t kMost = 1024;
        return static_cast<int>(std::bit_floor(
            std::clamp(static_cast<std::uint32_t>(std::max(samples, 1)), kLeast, kMost)));
    }
    return kDefault;
}

template <std::size_t layout>
LV2_Handle instantiate(const LV2_Descriptor*, double rate, const char* bundle,
                       const LV2_Feature* const* features) {
    try {
        const auto* const map =
            static_cast<const LV2_URID_Map*>(find_feature(features, LV2_URID__map));
        aula::plugin::PluginPorts ports{{.sample_rate_hz = rate,
                                         .block = block_size(features, map),
                                         .output = kLayouts[layout].output}};
        ports.folder = bundle;
        aula::check_output(ports, "plugin");
        return new Lv2Plugin(ports, map);
    } catch (const std::exception&) {
        return nullptr;
    }
}

Lv2Plugin& plugin_of(LV2_Handle handle) { return *static_cast<Lv2Plugin*>(handle); }

void connect_port(LV2_Handle handle, std::uint32_t port, void* data) {
    plugin_of(handle).connect(port, data);
}

void activate(LV2_Handle handle) { plugin_of(handle).activate(); }

void run(LV2_Handle handle, std::uint32_t samples) { plugin_of(handle).run(samples); }

void deactivate(LV2_Handle handle) { plugin_of(handle).deactivate(); }

void cleanup(LV2_Handle handle) { delete &plugin_of(handle); }

LV2_State_Status save(LV2_Handle handle, LV2_State_Store_Function store, LV2_State_Handle state,
                      std::uint32_t, const LV2_Feature* const* features) {
    return plugin_of(handle).save(store, state, features);
}

LV2_State_Status restore(LV2_Handle handle, LV2_State_Retrieve_Function retrieve,
                         LV2_State_Handle state, std::uint32_t,
                         const LV2_Feature* const* features) {
    plugin_of(handle).restore(retrieve, state, features);
    return LV2_STATE_SUCCESS;
}

const void* extension_data(const char* uri) {
    static const LV2_State_Interface kState{save, restore};
    return std::strcmp(uri, LV2_STATE__interface) == 0 ? &kState : nullptr;
}

template <std::size_t layout>
constexpr LV2_Descriptor descriptor{
    kPluginUris[layout], instantiate<layout>, connect_port, activate, run, deactivate, cleanup,
    extension_data};

constexpr std::array kDescriptors{&descriptor<0>, &descriptor<1>, &descriptor<2>};
static_assert(kDescriptors.size() == kLayouts.size());

}  // namespace

LV2_SYMBOL_EXPORT const LV2_Descriptor* lv2_descriptor(std::uint32_t index) {
    return index < kDescriptors.size() ? kDescriptors[index] : nullptr;
}
