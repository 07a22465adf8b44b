#pragma once

#include <clap/events.h>
#include <clap/ext/thread-check.h>
#include <clap/plugin.h>
#include <clap/stream.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/plugin/clap/clap_editor.h"
#include "apps/plugin/clap/extensions.h"
#include "apps/plugin/clap/parameter_events.h"
#include "apps/plugin/plugin_instance.h"

namespace aula::plugin {

/// An instance of a CLAP plugin: connects events, ports and streams with a PluginInstance. A call
/// on a wrong thread is refused where it would do harm.
class ClapPlugin {
 public:
    /// Destroyed by the host, with functions().
    ClapPlugin(const clap_host_t& host, const Kind& kind,
               const clap_plugin_descriptor_t& descriptor, const std::filesystem::path& folder);
    ClapPlugin(const ClapPlugin&) = delete;
    ClapPlugin& operator=(const ClapPlugin&) = delete;

    const clap_plugin_t* functions() const { return &functions_; }
    static ClapPlugin& of(const clap_plugin_t* plugin) {
        return *static_cast<ClapPlugin*>(plugin->plugin_data);
    }
    PluginInstance& instance() { return instance_; }

    // [main thread]
    bool init();
    bool activate(double sample_rate_hz, std::uint32_t longest_block);
    void deactivate();
    bool save(const clap_ostream_t& stream) const;
    bool load(const clap_istream_t& stream);
    /// Logs a new status.
    void report();

    // [audio thread]
    clap_process_status process(const clap_process_t& call);
    void reset();

    /// Applies changes of parameters, and tells the host those of the editor; both may be null.
    /// [the audio thread while active, else the main thread]
    void flush(const clap_input_events_t* in, const clap_output_events_t* out);

    // [main thread]
    /// False, with a line in the log of the host, if there can be none.
    bool create_editor();
    bool open_editor(std::uintptr_t parent);
    void destroy_editor();
    /// The editor, or null.
    ClapEditor* editor() { return editor_.get(); }

 private:
    bool is_main_thread() const;
    void log(HostLog::Severity severity, const char* line) const;
    void apply(const clap_event_header_t& event);
    void begin_block(const clap_event_transport_t* transport);

    const clap_host_t& host_;
    PluginInstance instance_;
    clap_plugin_t functions_;
    const clap_host_thread_check_t* threads_ = nullptr;
    const HostLog* log_ = nullptr;
    double sample_rate_hz_ = 0;
    std::vector<float*> outputs_;
    ParameterEvents events_;
    std::unique_ptr<ClapEditor> editor_;
};

/// An extension of the plugins, or null.
const void* find_extension(const char* id);

}  // namespace aula::plugin
