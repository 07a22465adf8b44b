// The entry points of the module and the factory of its plugins.

#include <travesty/factory.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <filesystem>
#include <span>

#if defined(_WIN32)
#include "process/child_process.h"
#else
#include <dlfcn.h>
#endif

#include "apps/plugin/vst3/vst3_plugin.h"
#include "process/module.h"

#if defined(_WIN32)
#define AULA_EXPORT extern "C" __declspec(dllexport)
#else
#define AULA_EXPORT extern "C" __attribute__((visibility("default")))
#endif

namespace {

using namespace aula::plugin;

/// Classes of the kinds. Hosts store them: they never change.
constexpr std::uint32_t kAula = 0x41756C61;  // "Aula"
constexpr std::uint32_t kRoom = 0x526F6F6D;  // "Room"
constexpr v3_tuid kClasses[kKinds.size()] = {
    V3_ID(kAula, kRoom, 0x6D6F6E6F, 0x62696E00), V3_ID(kAula, kRoom, 0x6D6F6E6F, 0x666F6100),
    V3_ID(kAula, kRoom, 0x6D6F6E6F, 0x746F6100), V3_ID(kAula, kRoom, 0x73746572, 0x62696E00),
    V3_ID(kAula, kRoom, 0x73746572, 0x666F6100), V3_ID(kAula, kRoom, 0x73746572, 0x746F6100)};

constexpr std::int32_t kManyInstances = 0x7FFFFFFF;
constexpr const char* kCategory = "Audio Module Class";

void copy_text(const char* text, std::span<char> to) {
    const std::size_t size = std::min(std::strlen(text), to.size() - 1);
    std::copy_n(text, size, to.begin());
    to[size] = 0;
}

/// Contents/Resources of the bundle, whose module is in Contents/ARCHITECTURE.
std::filesystem::path resources() {
#if defined(_WIN32)
    const std::filesystem::path module = aula::beside_binary("aula.vst3");
#else
    Dl_info info;
    if (dladdr(reinterpret_cast<const void*>(&resources), &info) == 0) return {};
    const std::filesystem::path module = info.dli_fname;
#endif
    return module.parent_path().parent_path() / "Resources";
}

// The factory is constant: references do not count.
v3_result query(void* self, const v3_tuid id, void** found) {
    const bool known = v3_tuid_match(id, v3_funknown_iid) ||
                       v3_tuid_match(id, v3_plugin_factory_iid) ||
                       v3_tuid_match(id, v3_plugin_factory_2_iid);
    *found = known ? self : nullptr;
    return known ? V3_OK : V3_NO_INTERFACE;
}
std::uint32_t reference(void*) { return 1; }

v3_result factory_info(void*, v3_factory_info* info) {
    *info = {};
    copy_text("Aula", info->vendor);
    info->flags = 0x10;  // texts are in Unicode
    return V3_OK;
}

std::int32_t class_count(void*) { return kKinds.size(); }

bool is_class(std::int32_t index) {
    return index >= 0 && static_cast<std::size_t>(index) < kKinds.size();
}

v3_result class_info(void*, std::int32_t index, v3_class_info* info) {
    if (!is_class(index)) return V3_INVALID_ARG;
    *info = {};
    std::memcpy(info->class_id, kClasses[index], sizeof(v3_tuid));
    info->cardinality = kManyInstances;
    copy_text(kCategory, info->category);
    copy_text(kKinds[static_cast<std::size_t>(index)].id, info->name);
    return V3_OK;
}

v3_result class_info_2(void*, std::int32_t index, v3_class_info_2* info) {
    if (!is_class(index)) return V3_INVALID_ARG;
    const Kind& kind = kKinds[static_cast<std::size_t>(index)];
    const bool is_field = kind.output != aula::OutputFormat::binaural;
    *info = {};
    std::memcpy(info->class_id, kClasses[index], sizeof(v3_tuid));
    info->cardinality = kManyInstances;
    copy_text(kCategory, info->category);
    copy_text(kind.id, info->name);
    copy_text(is_field ? "Fx|Reverb|Ambisonics" : "Fx|Reverb|Spatial", info->sub_categories);
    copy_text("Aula", info->vendor);
    copy_text(AULA_VERSION, info->version);
    copy_text("VST 3.7", info->sdk_version);
    return V3_OK;
}

v3_result create(void*, const v3_tuid class_id, const v3_tuid interface_id, void** instance) {
    *instance = nullptr;
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
        if (!v3_tuid_match(class_id, kClasses[i])) continue;
        try {
            auto* const plugin = new Vst3Plugin(kKinds[i], resources());
            const v3_result result = plugin->find_interface(interface_id, instance);
            plugin->release();
            return result;
        } catch (const std::exception&) {
            return V3_INTERNAL_ERR;
        }
    }
    return V3_INVALID_ARG;
}

struct Factory : v3_funknown {
    v3_plugin_factory first;
    v3_plugin_factory_2 second;
};

const Factory kFactory{
    {query, reference, reference}, {factory_info, class_count, class_info, create}, {class_info_2}};
const Factory* const kFactoryObject = &kFactory;

}  // namespace

AULA_EXPORT const void* GetPluginFactory();
const void* GetPluginFactory() { return &kFactoryObject; }

#if defined(_WIN32)
AULA_EXPORT bool InitDll();
AULA_EXPORT bool ExitDll();
bool InitDll() { return aula::prepare_module(); }
bool ExitDll() { return true; }
#else
AULA_EXPORT bool ModuleEntry(void* library);
AULA_EXPORT bool ModuleExit();
bool ModuleEntry(void*) { return aula::prepare_module(); }
bool ModuleExit() { return true; }
#endif
