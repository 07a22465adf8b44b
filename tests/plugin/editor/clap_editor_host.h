#pragma once

#include <clap/ext/gui.h>

#include <string>
#include <utility>

#include "apps/plugin/editor/window_system.h"
#include "tests/plugin/clap_host.h"
#include "tests/plugin/editor/editor_format.h"

namespace aula::test {

class ClapEditorHost final : public EditorFormat {
 public:
    ClapEditorHost() : host_("aula.room.binaural") {}
    ~ClapEditorHost() override { close(); }

    bool open(std::uintptr_t parent) override {
        const clap_plugin_t* const plugin = &host_.plugin();
        if (!gui().is_api_supported(plugin, plugin::kWindowSystem.clap_api, false)) return false;
        if (!gui().create(plugin, plugin::kWindowSystem.clap_api, false)) return false;
        is_open_ = true;
        clap_window_t window{};
        window.api = plugin::kWindowSystem.clap_api;
        window.ptr = reinterpret_cast<void*>(parent);
        return gui().set_parent(plugin, &window) && gui().show(plugin) &&
               host_.has_timer() != plugin::kWindowSystem.has_timers;
    }
    void idle() override { host_.tick(); }
    void close() override {
        if (!std::exchange(is_open_, false)) return;
        gui().destroy(&host_.plugin());
        demand(!host_.has_timer(), "the timer is left");
    }

    std::pair<unsigned, unsigned> size() const {
        std::uint32_t width = 0;
        std::uint32_t height = 0;
        gui().get_size(&host_.plugin(), &width, &height);
        return {width, height};
    }
    std::string logged() const { return host_.logged(); }

    double get(plugin::Control control) const override { return host_.get(control); }
    void set(plugin::Control control, double value) override { host_.flush(control, value); }
    double told(plugin::Control control) const override {
        double value = -1e9;
        for (const ClapHost::Edit& edit : host_.edits())
            if (edit.type == CLAP_EVENT_PARAM_VALUE && edit.control == control) value = edit.value;
        return value;
    }
    int gestures() const override {
        return count(CLAP_EVENT_PARAM_GESTURE_BEGIN) - count(CLAP_EVENT_PARAM_GESTURE_END);
    }
    int told_changes() const override { return host_.state_changes(); }
    int ended_gestures() const override { return count(CLAP_EVENT_PARAM_GESTURE_END); }

 private:
    const clap_plugin_gui_t& gui() const {
        return host_.extension<clap_plugin_gui_t>(CLAP_EXT_GUI);
    }
    int count(int type) const {
        int found = 0;
        for (const ClapHost::Edit& edit : host_.edits()) found += edit.type == type ? 1 : 0;
        return found;
    }

    ClapHost host_;
    bool is_open_ = false;
};

}  // namespace aula::test
