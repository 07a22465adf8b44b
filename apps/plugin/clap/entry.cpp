// The entry point of the file and the descriptors of its plugins.

#include <clap/entry.h>
#if __has_include(<clap/factory/plugin-factory.h>)
#include <clap/factory/plugin-factory.h>
#else
#include <clap/plugin-factory.h>
#endif
#include <clap/plugin-features.h>

#include <array>
#include <cstring>
#include <exception>
#include <filesystem>

#include "apps/plugin/clap/clap_plugin.h"
#include "process/files.h"
#include "process/module.h"

namespace {

using namespace aula::plugin;

const char* kEar[] = {CLAP_PLUGIN_FEATURE_AUDIO_EFFECT, CLAP_PLUGIN_FEATURE_REVERB,
                      CLAP_PLUGIN_FEATURE_STEREO, nullptr};
const char* kField[] = {CLAP_PLUGIN_FEATURE_AUDIO_EFFECT, CLAP_PLUGIN_FEATURE_REVERB,
                        CLAP_PLUGIN_FEATURE_AMBISONIC, nullptr};

clap_plugin_descriptor_t descriptor(std::size_t index) {
    const Kind& kind = kKinds[index];
    return {.clap_version = CLAP_VERSION,
            .id = kind.id,
            .name = kind.name,
            .vendor = "Aula",
            .url = "",
            .manual_url = "",
            .support_url = "",
            .version = AULA_VERSION,
            .description =
                "The sound of a source at a place in a room: direct sound, reflections "
                "and reverberation of the geometry and materials of a scene.",
            .features = kind.output == aula::OutputFormat::binaural ? kEar : kField};
}

const std::array kDescriptors{descriptor(0), descriptor(1), descriptor(2),
                              descriptor(3), descriptor(4), descriptor(5)};
static_assert(kDescriptors.size() == kKinds.size());

/// Of the file of the plugins.
std::filesystem::path& folder() {
    static std::filesystem::path path;
    return path;
}

std::uint32_t count(const clap_plugin_factory_t*) { return kDescriptors.size(); }

const clap_plugin_descriptor_t* descriptor_at(const clap_plugin_factory_t*, std::uint32_t index) {
    return index < kDescriptors.size() ? &kDescriptors[index] : nullptr;
}

const clap_plugin_t* create(const clap_plugin_factory_t*, const clap_host_t* host, const char* id) {
    try {
        for (std::size_t i = 0; i < kKinds.size(); ++i)
            if (std::strcmp(kKinds[i].id, id) == 0)
                return (new ClapPlugin(*host, kKinds[i], kDescriptors[i], folder()))->functions();
    } catch (const std::exception&) {
    }
    return nullptr;
}

const clap_plugin_factory_t kFactory{count, descriptor_at, create};

}  // namespace

extern "C" CLAP_EXPORT const clap_plugin_entry_t clap_entry{
    .clap_version = CLAP_VERSION,
    .init =
        [](const char* file) {
            if (!aula::prepare_module()) return false;
            folder() = aula::utf8_path(file).parent_path();
            return true;
        },
    .deinit = [] {},
    .get_factory = [](const char* id) -> const void* {
        return std::strcmp(id, CLAP_PLUGIN_FACTORY_ID) == 0 ? &kFactory : nullptr;
    }};
