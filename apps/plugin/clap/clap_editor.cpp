#include "apps/plugin/clap/clap_editor.h"

#include <clap/ext/params.h>
#include <clap/ext/state.h>

#include <cstring>
#include <string_view>
#include <utility>

#include "apps/plugin/clap/clap_plugin.h"
#include "apps/plugin/editor/window_system.h"

namespace aula::plugin {

namespace {

/// An extension of the host, or null.
template <typename Extension>
const Extension* extension_of(const clap_host_t& host, const char* id) {
    return static_cast<const Extension*>(host.get_extension(&host, id));
}

PluginEditor* editor_of(const clap_plugin_t* plugin) {
    ClapEditor* const editor = ClapPlugin::of(plugin).editor();
    return editor != nullptr ? &editor->editor() : nullptr;
}

bool is_supported(const clap_plugin_t*, const char* api, bool is_floating) {
    return !is_floating && std::string_view(api) == kWindowSystem.clap_api;
}

bool preferred(const clap_plugin_t*, const char** api, bool* is_floating) {
    *api = kWindowSystem.clap_api;
    *is_floating = false;
    return true;
}

bool create(const clap_plugin_t* plugin, const char* api, bool is_floating) {
    return is_supported(plugin, api, is_floating) && ClapPlugin::of(plugin).create_editor();
}

void destroy(const clap_plugin_t* plugin) { ClapPlugin::of(plugin).destroy_editor(); }

bool get_size(const clap_plugin_t* plugin, std::uint32_t* width, std::uint32_t* height) {
    const PluginEditor* const editor = editor_of(plugin);
    if (editor == nullptr) return false;
    *width = editor->size().width;
    *height = editor->size().height;
    return true;
}

bool resize_hints(const clap_plugin_t*, clap_gui_resize_hints_t* hints) {
    *hints = {.can_resize_horizontally = true,
              .can_resize_vertically = true,
              .preserve_aspect_ratio = false,
              .aspect_ratio_width = 0,
              .aspect_ratio_height = 0};
    return true;
}

bool adjust_size(const clap_plugin_t* plugin, std::uint32_t* width, std::uint32_t* height) {
    const PluginEditor* const editor = editor_of(plugin);
    if (editor == nullptr) return false;
    const EditorSize size = editor->allowed({*width, *height});
    *width = size.width;
    *height = size.height;
    return true;
}

bool set_size(const clap_plugin_t* plugin, std::uint32_t width, std::uint32_t height) {
    PluginEditor* const editor = editor_of(plugin);
    if (editor == nullptr) return false;
    editor->resize({width, height});
    return true;
}

bool set_parent(const clap_plugin_t* plugin, const clap_window_t* window) {
    return std::string_view(window->api) == kWindowSystem.clap_api &&
           ClapPlugin::of(plugin).open_editor(reinterpret_cast<std::uintptr_t>(window->ptr));
}

bool show(const clap_plugin_t* plugin) {
    ClapEditor* const editor = ClapPlugin::of(plugin).editor();
    if (editor == nullptr || editor->editor().window() == 0) return false;
    if (!editor->start_timer()) return false;
    editor->editor().show();
    return true;
}

bool hide(const clap_plugin_t* plugin) {
    ClapEditor* const editor = ClapPlugin::of(plugin).editor();
    if (editor == nullptr || editor->editor().window() == 0) return false;
    editor->stop_timer();
    editor->editor().hide();
    return true;
}

constexpr clap_plugin_gui_t kGui{is_supported,
                                 preferred,
                                 create,
                                 destroy,
                                 [](const clap_plugin_t*, double) { return false; },
                                 get_size,
                                 [](const clap_plugin_t*) { return true; },
                                 resize_hints,
                                 adjust_size,
                                 set_size,
                                 set_parent,
                                 [](const clap_plugin_t*, const clap_window_t*) { return false; },
                                 [](const clap_plugin_t*, const char*) {},
                                 show,
                                 hide};

constexpr clap_plugin_timer_support_t kTimer{[](const clap_plugin_t* plugin, clap_id id) {
    if (ClapEditor* const editor = ClapPlugin::of(plugin).editor()) editor->on_timer(id);
}};

}  // namespace

ClapEditor::ClapEditor(const clap_host_t& host, PluginInstance& instance, ParameterEvents& events)
    : host_(host), instance_(instance), events_(events), editor_(*this) {}

ClapEditor::~ClapEditor() { stop_timer(); }

bool ClapEditor::start_timer() {
    if (kWindowSystem.has_timers || has_timer_) return true;
    const auto* const timers =
        extension_of<clap_host_timer_support_t>(host_, CLAP_EXT_TIMER_SUPPORT);
    has_timer_ =
        timers != nullptr && timers->register_timer(&host_, PluginEditor::kPeriod_ms, &timer_);
    return has_timer_;
}

void ClapEditor::stop_timer() {
    if (!std::exchange(has_timer_, false)) return;
    extension_of<clap_host_timer_support_t>(host_, CLAP_EXT_TIMER_SUPPORT)
        ->unregister_timer(&host_, timer_);
}

void ClapEditor::send(const ParameterEvents::Event& event) {
    events_.push(event);
    const auto* const parameters = extension_of<clap_host_params_t>(host_, CLAP_EXT_PARAMS);
    if (parameters != nullptr) parameters->request_flush(&host_);
}

void ClapEditor::begin_change(Control control) {
    send({.type = CLAP_EVENT_PARAM_GESTURE_BEGIN, .control = control});
}

void ClapEditor::end_change(Control control) {
    send({.type = CLAP_EVENT_PARAM_GESTURE_END, .control = control});
}

void ClapEditor::change(Control control, float value) {
    instance_.set_parameter(control, static_cast<double>(value));
    send({.control = control, .value = instance_.parameter(control)});
}

void ClapEditor::choose_scene(const std::filesystem::path& file) {
    instance_.choose_scene(file);
    const auto* const state = extension_of<clap_host_state_t>(host_, CLAP_EXT_STATE);
    if (state != nullptr) state->mark_dirty(&host_);
}

const void* find_editor_extension(const char* id) {
    if (!PluginEditor::is_built()) return nullptr;
    if (std::strcmp(id, CLAP_EXT_GUI) == 0) return &kGui;
    if (std::strcmp(id, CLAP_EXT_TIMER_SUPPORT) == 0) return &kTimer;
    return nullptr;
}

}  // namespace aula::plugin
