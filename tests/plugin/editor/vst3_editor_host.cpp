#include "tests/plugin/editor/vst3_editor_host.h"

#include <utility>

#include "apps/plugin/editor/window_system.h"

namespace aula::test {

namespace {

/// The plain value of a parameter, and from 0 to 1.
double plain(const Vst3Host& host, plugin::Control control, double normalised) {
    return v3_cpp_obj(host.controller())
        ->normalised_parameter_to_plain(host.controller(), static_cast<v3_param_id>(control),
                                        normalised);
}

}  // namespace

v3_result Vst3EditorHost::query(void* self, const v3_tuid id, void** found) {
    *found = nullptr;
    if (v3_tuid_match(id, v3_run_loop_iid)) *found = &of(self).loop_;
    if (v3_tuid_match(id, v3_component_handler2_iid)) *found = &of(self).marks_;
    return *found != nullptr ? V3_OK : V3_NO_INTERFACE;
}

const Vst3EditorHost::HandlerFunctions& Vst3EditorHost::handler_functions() {
    static const HandlerFunctions functions = [] {
        HandlerFunctions f{};
        static_cast<v3_funknown&>(f) = {query, count, count};
        f.comp = {[](void* self, v3_param_id) -> v3_result {
                      ++of(self).begun_;
                      return V3_OK;
                  },
                  [](void* self, v3_param_id id, double value) -> v3_result {
                      of(self).told_[id] =
                          plain(of(self).host_, static_cast<plugin::Control>(id), value);
                      return V3_OK;
                  },
                  [](void* self, v3_param_id) -> v3_result {
                      ++of(self).ended_;
                      return V3_OK;
                  },
                  [](void*, std::int32_t) -> v3_result { return V3_OK; }};
        return f;
    }();
    return functions;
}

const Vst3EditorHost::MarkFunctions& Vst3EditorHost::mark_functions() {
    static const MarkFunctions functions = [] {
        MarkFunctions f{};
        static_cast<v3_funknown&>(f) = {query, count, count};
        f.marks = {[](void* self, v3_bool is_changed) -> v3_result {
                       if (is_changed != 0) ++of(self).told_changes_;
                       return V3_OK;
                   },
                   [](void*, const char*) -> v3_result { return V3_OK; },
                   [](void*) -> v3_result { return V3_OK; },
                   [](void*) -> v3_result { return V3_OK; }};
        return f;
    }();
    return functions;
}

const v3_plugin_frame_cpp& Vst3EditorHost::frame_functions() {
    static const v3_plugin_frame_cpp functions = [] {
        v3_plugin_frame_cpp f{};
        static_cast<v3_funknown&>(f) = {query, count, count};
        f.frame = {[](void*, v3_plugin_view**, v3_view_rect*) -> v3_result { return V3_OK; }};
        return f;
    }();
    return functions;
}

const v3_run_loop_cpp& Vst3EditorHost::loop_functions() {
    static const v3_run_loop_cpp functions = [] {
        v3_run_loop_cpp f{};
        static_cast<v3_funknown&>(f) = {query, count, count};
        f.loop = {[](void*, v3_event_handler**, int) -> v3_result { return V3_OK; },
                  [](void*, v3_event_handler**) -> v3_result { return V3_OK; },
                  [](void* self, v3_timer_handler** timer, std::uint64_t) -> v3_result {
                      of(self).timer_ = timer;
                      return V3_OK;
                  },
                  [](void* self, v3_timer_handler** timer) -> v3_result {
                      return std::exchange(of(self).timer_, nullptr) == timer ? V3_OK
                                                                              : V3_INVALID_ARG;
                  }};
        return f;
    }();
    return functions;
}

Vst3EditorHost::Vst3EditorHost()
    : handler_{&handler_functions(), this},
      marks_{&mark_functions(), this},
      frame_{&frame_functions(), this},
      loop_{&loop_functions(), this},
      host_("aula.room.binaural") {
    v3_cpp_obj(host_.controller())
        ->set_component_handler(host_.controller(),
                                reinterpret_cast<v3_component_handler**>(&handler_));
}

Vst3EditorHost::~Vst3EditorHost() {
    close();
    v3_cpp_obj(host_.controller())->set_component_handler(host_.controller(), nullptr);
}

bool Vst3EditorHost::open(std::uintptr_t parent) {
    view_ = v3_cpp_obj(host_.controller())->create_view(host_.controller(), "editor");
    if (view_ == nullptr) return false;
    const auto& functions = *v3_cpp_obj(view_);
    functions.set_frame(view_, reinterpret_cast<v3_plugin_frame**>(&frame_));
    v3_view_rect size{};
    return functions.is_platform_type_supported(view_, plugin::kWindowSystem.vst3_platform) ==
               V3_OK &&
           functions.get_size(view_, &size) == V3_OK && size.right > 100 &&
           functions.attached(view_, reinterpret_cast<void*>(parent),
                              plugin::kWindowSystem.vst3_platform) == V3_OK &&
           (timer_ != nullptr) != plugin::kWindowSystem.has_timers;
}

void Vst3EditorHost::idle() {
    if (timer_ != nullptr) v3_cpp_obj(timer_)->on_timer(timer_);
}

void Vst3EditorHost::close() {
    if (view_ == nullptr) return;
    v3_cpp_obj(view_)->removed(view_);
    demand(timer_ == nullptr, "the timer is left");
    demand(v3_cpp_obj_unref(view_) == 0, "a reference is left");
    view_ = nullptr;
}

double Vst3EditorHost::get(plugin::Control control) const {
    const auto id = static_cast<v3_param_id>(control);
    return plain(host_, control,
                 v3_cpp_obj(host_.controller())->get_parameter_normalised(host_.controller(), id));
}

void Vst3EditorHost::set(plugin::Control control, double value) {
    const auto id = static_cast<v3_param_id>(control);
    const auto& functions = *v3_cpp_obj(host_.controller());
    functions.set_parameter_normalised(
        host_.controller(), id,
        functions.plain_parameter_to_normalised(host_.controller(), id, value));
}

double Vst3EditorHost::told(plugin::Control control) const {
    return told_[static_cast<std::size_t>(control)];
}

}  // namespace aula::test
