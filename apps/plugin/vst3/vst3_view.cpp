#include "apps/plugin/vst3/vst3_view.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

#include "apps/plugin/editor/window_system.h"

namespace aula::plugin {

namespace {

v3_result view_query(void* self, const v3_tuid id, void** found) {
    return vst3_view(self).find_interface(id, found);
}
std::uint32_t view_reference(void* self) { return vst3_view(self).reference(); }
std::uint32_t view_release(void* self) { return vst3_view(self).release(); }

v3_result is_supported(void*, const char* platform) {
    return std::strcmp(platform, kWindowSystem.vst3_platform) == 0 ? V3_TRUE : V3_FALSE;
}
v3_result attached(void* self, void* parent, const char* platform) {
    if (is_supported(self, platform) != V3_TRUE) return V3_INVALID_ARG;
    return vst3_view(self).attach(parent);
}
v3_result removed(void* self) { return vst3_view(self).remove(); }

// The window system tells the editor of the mouse.
v3_result on_wheel(void*, float) { return V3_FALSE; }
v3_result on_key(void*, std::int16_t, std::int16_t, std::int16_t) { return V3_FALSE; }
v3_result on_focus(void*, v3_bool) { return V3_OK; }

v3_result get_size(void* self, v3_view_rect* size) {
    const PluginEditor* const editor = vst3_view(self).editor();
    if (editor == nullptr) return V3_FALSE;
    *size = {0, 0, static_cast<std::int32_t>(editor->size().width),
             static_cast<std::int32_t>(editor->size().height)};
    return V3_OK;
}

EditorSize size_of(const v3_view_rect& rect) {
    return {static_cast<unsigned>(std::max(rect.right - rect.left, 1)),
            static_cast<unsigned>(std::max(rect.bottom - rect.top, 1))};
}

v3_result on_size(void* self, v3_view_rect* size) {
    PluginEditor* const editor = vst3_view(self).editor();
    if (editor == nullptr) return V3_FALSE;
    editor->resize(size_of(*size));
    return V3_OK;
}

v3_result set_frame(void* self, v3_plugin_frame** frame) {
    vst3_view(self).set_frame(frame);
    return V3_OK;
}
v3_result can_resize(void*) { return V3_TRUE; }

v3_result check_size(void* self, v3_view_rect* size) {
    const PluginEditor* const editor = vst3_view(self).editor();
    if (editor == nullptr) return V3_FALSE;
    const EditorSize allowed = editor->allowed(size_of(*size));
    size->right = size->left + static_cast<std::int32_t>(allowed.width);
    size->bottom = size->top + static_cast<std::int32_t>(allowed.height);
    return V3_TRUE;
}

void on_timer(void* self) {
    if (PluginEditor* const editor = vst3_view(self).editor()) editor->idle();
}

const v3_plugin_view_cpp kView{{view_query, view_reference, view_release},
                               {is_supported, attached, removed, on_wheel, on_key, on_key, get_size,
                                on_size, on_focus, set_frame, can_resize, check_size}};

const v3_timer_handler_cpp kTimer{{view_query, view_reference, view_release}, {on_timer}};

}  // namespace

Vst3View& vst3_view(void* self) { return *static_cast<Vst3View::Interface*>(self)->view; }

Vst3View::Vst3View(Vst3Plugin& plugin)
    : view_{&kView, this}, timer_{&kTimer, this}, plugin_(plugin) {
    plugin_.reference();
}

Vst3View::~Vst3View() {
    remove();
    set_frame(nullptr);
    plugin_.release();
}

v3_result Vst3View::find_interface(const v3_tuid id, void** found) {
    *found = nullptr;
    if (v3_tuid_match(id, v3_funknown_iid) || v3_tuid_match(id, v3_plugin_view_iid))
        *found = &view_;
    else if (v3_tuid_match(id, v3_timer_handler_iid))
        *found = &timer_;
    if (*found == nullptr) return V3_NO_INTERFACE;
    reference();
    return V3_OK;
}

std::uint32_t Vst3View::release() {
    const std::uint32_t left = --references_;
    if (left == 0) delete this;
    return left;
}

PluginEditor* Vst3View::editor() {
    try {
        if (!editor_) editor_ = std::make_unique<PluginEditor>(*this);
    } catch (const std::exception&) {
        // VST3 has no log.
    }
    return editor_.get();
}

v3_result Vst3View::attach(void* parent) {
    if (is_attached_ || editor() == nullptr) return V3_FALSE;
    is_attached_ = true;
    try {
        editor_->open(reinterpret_cast<std::uintptr_t>(parent));
        editor_->show();
        if (kWindowSystem.has_timers || start_timer()) return V3_OK;
    } catch (const std::exception&) {
        // VST3 has no log.
    }
    remove();
    return V3_FALSE;
}

/// The timer is that of the run loop, which a frame has on Linux.
bool Vst3View::start_timer() {
    if (frame_ == nullptr || v3_cpp_obj_query_interface(frame_, v3_run_loop_iid, &loop_) != V3_OK) {
        loop_ = nullptr;
        return false;
    }
    return v3_cpp_obj(loop_)->register_timer(loop_, reinterpret_cast<v3_timer_handler**>(&timer_),
                                             PluginEditor::kPeriod_ms) == V3_OK;
}

v3_result Vst3View::remove() {
    stop_timer();
    editor_.reset();
    is_attached_ = false;
    return V3_OK;
}

void Vst3View::stop_timer() {
    if (loop_ == nullptr) return;
    v3_run_loop** const loop = std::exchange(loop_, nullptr);
    v3_cpp_obj(loop)->unregister_timer(loop, reinterpret_cast<v3_timer_handler**>(&timer_));
    v3_cpp_obj_unref(loop);
}

void Vst3View::set_frame(v3_plugin_frame** frame) {
    if (frame != nullptr) v3_cpp_obj_ref(frame);
    if (frame_ != nullptr) v3_cpp_obj_unref(frame_);
    frame_ = frame;
}

void Vst3View::begin_change(Control control) {
    if (v3_component_handler** const handler = plugin_.handler())
        v3_cpp_obj(handler)->begin_edit(handler, static_cast<v3_param_id>(control));
}

void Vst3View::end_change(Control control) {
    if (v3_component_handler** const handler = plugin_.handler())
        v3_cpp_obj(handler)->end_edit(handler, static_cast<v3_param_id>(control));
}

void Vst3View::change(Control control, float value) {
    instance().set_parameter(control, static_cast<double>(value));
    if (v3_component_handler** const handler = plugin_.handler())
        v3_cpp_obj(handler)->perform_edit(handler, static_cast<v3_param_id>(control),
                                          to_normalised(control, instance().parameter(control)));
}

/// The scene is no parameter: the host is told that its project has changed.
void Vst3View::choose_scene(const std::filesystem::path& file) {
    instance().choose_scene(file);
    v3_component_handler2** marks = nullptr;
    if (plugin_.handler() == nullptr ||
        v3_cpp_obj_query_interface(plugin_.handler(), v3_component_handler2_iid, &marks) != V3_OK)
        return;
    v3_cpp_obj(marks)->set_dirty(marks, true);
    v3_cpp_obj_unref(marks);
}

}  // namespace aula::plugin
