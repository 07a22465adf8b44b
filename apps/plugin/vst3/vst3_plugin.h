#pragma once

#include <travesty/audio_processor.h>
#include <travesty/component.h>
#include <travesty/edit_controller.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/plugin/plugin_instance.h"

namespace aula::plugin {

/// An instance of a VST3 plugin: one object that is component, processor and controller. Connects
/// queues of parameters, buses and streams with a PluginInstance. It begins with one reference.
class Vst3Plugin {
 public:
    Vst3Plugin(const Kind& kind, const std::filesystem::path& folder);
    ~Vst3Plugin();
    Vst3Plugin(const Vst3Plugin&) = delete;
    Vst3Plugin& operator=(const Vst3Plugin&) = delete;

    PluginInstance& instance() { return instance_; }

    v3_result find_interface(const v3_tuid id, void** found);
    std::uint32_t reference() { return ++references_; }
    /// The object ends with its last reference.
    std::uint32_t release();

    // [main thread]
    v3_result set_up(const v3_process_setup& setup);
    v3_result set_active(bool is_active);
    v3_result save(v3_bstream** stream) const;
    v3_result load(v3_bstream** stream);
    void set_handler(v3_component_handler** handler);
    /// Of the host, or null.
    v3_component_handler** handler() const { return handler_; }

    /// [audio thread]
    v3_result process(const v3_process_data& block);

 private:
    /// What a host sees: the address of the functions first.
    struct Interface {
        const void* functions;
        Vst3Plugin* plugin;
    };
    friend Vst3Plugin& vst3_plugin(void* self);

    std::int32_t apply(v3_param_changes** changes, std::int32_t sample, std::int32_t end);

    std::atomic<std::uint32_t> references_ = 1;
    Interface component_;
    Interface processor_;
    Interface controller_;
    PluginInstance instance_;
    v3_component_handler** handler_ = nullptr;
    double sample_rate_hz_ = 48000;
    std::uint32_t longest_block_ = 1024;
};

/// The instance of an interface.
Vst3Plugin& vst3_plugin(void* self);

/// Functions of the interfaces.
extern const v3_component_cpp kVst3Component;
extern const v3_audio_processor_cpp kVst3Processor;
extern const v3_edit_controller_cpp kVst3Controller;

/// The value of a parameter from 0 to 1, and back.
double to_normalised(Control control, double value);
double from_normalised(Control control, double normalised);

}  // namespace aula::plugin
