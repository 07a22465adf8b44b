#pragma once

#include <travesty/view.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/plugin/editor/plugin_editor.h"
#include "apps/plugin/vst3/vst3_plugin.h"

namespace aula::plugin {

/// The view of a VST3 plugin: one object that is the view and the handler of a timer of the host.
/// It begins with one reference, and keeps the plugin. [main thread]
class Vst3View final : public EditorHost {
 public:
    explicit Vst3View(Vst3Plugin& plugin);
    ~Vst3View() override;

    /// What a host sees.
    v3_plugin_view** view() { return reinterpret_cast<v3_plugin_view**>(&view_); }

    v3_result find_interface(const v3_tuid id, void** found);
    std::uint32_t reference() { return ++references_; }
    std::uint32_t release();

    v3_result attach(void* parent);
    v3_result remove();
    /// The editor, which is made when it is first needed; null if there can be none.
    PluginEditor* editor();
    void set_frame(v3_plugin_frame** frame);

    std::size_t sources() const override { return instance().kind().sources; }
    std::filesystem::path folder() const override { return instance().folder(); }
    ControlValues values() const override { return instance().values(); }
    RoomFiles files() const override { return instance().files(); }
    float level_db() const override { return instance().level_db(); }
    std::string status() const override { return instance().status(); }
    void begin_change(Control control) override;
    void end_change(Control control) override;
    void change(Control control, float value) override;
    void choose_scene(const std::filesystem::path& file) override;

 private:
    /// What a host sees: the address of the functions first.
    struct Interface {
        const void* functions;
        Vst3View* view;
    };
    friend Vst3View& vst3_view(void* self);

    PluginInstance& instance() const { return plugin_.instance(); }
    bool start_timer();
    void stop_timer();

    std::atomic<std::uint32_t> references_ = 1;
    Interface view_;
    Interface timer_;
    Vst3Plugin& plugin_;
    v3_plugin_frame** frame_ = nullptr;
    v3_run_loop** loop_ = nullptr;  ///< with a timer
    bool is_attached_ = false;
    std::unique_ptr<PluginEditor> editor_;
};

/// The view of an interface.
Vst3View& vst3_view(void* self);

}  // namespace aula::plugin
