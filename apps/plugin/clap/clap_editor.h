#pragma once

#include <clap/ext/gui.h>
#include <clap/ext/timer-support.h>

#include <filesystem>
#include <string>

#include "apps/plugin/clap/parameter_events.h"
#include "apps/plugin/editor/plugin_editor.h"
#include "apps/plugin/plugin_instance.h"

namespace aula::plugin {

/// The editor of a CLAP plugin: connects it with the instance, the events for the host, and a timer
/// of the host. [main thread]
class ClapEditor final : public EditorHost {
 public:
    /// Throws Failure.
    ClapEditor(const clap_host_t& host, PluginInstance& instance, ParameterEvents& events);
    ~ClapEditor() override;

    PluginEditor& editor() { return editor_; }
    /// False if the host has no timer.
    bool start_timer();
    void stop_timer();
    void on_timer(clap_id id) {
        if (has_timer_ && id == timer_) editor_.idle();
    }

    std::size_t sources() const override { return instance_.kind().sources; }
    std::filesystem::path folder() const override { return instance_.folder(); }
    ControlValues values() const override { return instance_.values(); }
    RoomFiles files() const override { return instance_.files(); }
    float level_db() const override { return instance_.level_db(); }
    std::string status() const override { return instance_.status(); }
    void begin_change(Control control) override;
    void end_change(Control control) override;
    void change(Control control, float value) override;
    void choose_scene(const std::filesystem::path& file) override;

 private:
    void send(const ParameterEvents::Event& event);

    const clap_host_t& host_;
    PluginInstance& instance_;
    ParameterEvents& events_;
    bool has_timer_ = false;
    clap_id timer_ = CLAP_INVALID_ID;
    PluginEditor editor_;
};

/// The functions of the extensions of an editor by their names, or null.
const void* find_editor_extension(const char* id);

}  // namespace aula::plugin
