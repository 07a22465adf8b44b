#pragma once

#include <travesty/view.h>

#include <array>

#include "tests/plugin/editor/editor_format.h"
#include "tests/plugin/vst3/vst3_host.h"

namespace aula::test {

/// With a handler of parameters, a frame, and a run loop with one timer.
class Vst3EditorHost final : public EditorFormat {
 public:
    Vst3EditorHost();
    ~Vst3EditorHost() override;

    bool open(std::uintptr_t parent) override;
    void idle() override;
    void close() override;
    double get(plugin::Control control) const override;
    void set(plugin::Control control, double value) override;
    double told(plugin::Control control) const override;
    int gestures() const override { return begun_ - ended_; }
    int ended_gestures() const override { return ended_; }
    int told_changes() const override { return told_changes_; }

 private:
    struct Interface {
        const void* functions;
        Vst3EditorHost* host;
    };
    static Vst3EditorHost& of(void* self) { return *static_cast<Interface*>(self)->host; }
    static v3_result query(void* self, const v3_tuid id, void** found);
    static std::uint32_t count(void*) { return 1; }
    struct HandlerFunctions : v3_funknown {
        v3_component_handler comp;
    };
    static const HandlerFunctions& handler_functions();
    struct MarkFunctions : v3_funknown {
        v3_component_handler2 marks;
    };
    static const MarkFunctions& mark_functions();
    static const v3_plugin_frame_cpp& frame_functions();
    static const v3_run_loop_cpp& loop_functions();

    Interface handler_;
    Interface marks_;
    Interface frame_;
    Interface loop_;
    Vst3Host host_;
    v3_plugin_view** view_ = nullptr;
    v3_timer_handler** timer_ = nullptr;
    std::array<double, plugin::kControls> told_{};
    int begun_ = 0;
    int ended_ = 0;
    int told_changes_ = 0;
};

}  // namespace aula::test
