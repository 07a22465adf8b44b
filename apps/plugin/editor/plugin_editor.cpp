#include "apps/plugin/editor/plugin_editor.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

// The copy of dpf-source does not declare them as functions of C.
extern "C" {
#include <pugl/gl.h>
#include <pugl/pugl.h>
}

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "apps/drawing/input_events.h"
#include "apps/drawing/style.h"
#include "apps/plugin/editor/editor_panel.h"
#include "apps/plugin/editor/window_system.h"
#include "aula/exception.h"

namespace aula::plugin {

namespace {

/// At a scale of 1. In the least size nothing overlaps.
constexpr EditorSize kFirst{720, 440};
constexpr EditorSize kLeast{480, 320};
constexpr unsigned kGreatest = 8192;

/// Frames after an event: Dear ImGui shows some effects of the mouse one frame later.
constexpr int kFramesOfEvent = 2;

constexpr int kVersion = 33;  ///< of OpenGL, as of the program's window

EditorSize scaled(EditorSize size, float scale) {
    const auto pixels = [&](unsigned x) {
        return static_cast<unsigned>(std::lround(static_cast<float>(x) * scale));
    };
    return {pixels(size.width), pixels(size.height)};
}

}  // namespace

struct PluginEditor::State {
    explicit State(EditorHost& host) : panel(host) {}

    void create();
    void destroy();
    PuglStatus handle(const PuglEvent& event);
    void handle_mouse(const PuglEvent& event);
    void draw();

    EditorPanel panel;
    PuglWorld* world = nullptr;
    PuglView* view = nullptr;
    ImGuiContext* context = nullptr;
    MouseEvents mouse;
    ImVec2 mouse_at{-std::numeric_limits<float>::max(), -std::numeric_limits<float>::max()};
    EditorSize size{};
    float scale = 1;
    bool has_opengl = false;
    int frames_due = 0;
    double drawn_s = 0;
};

void PluginEditor::State::create() {
    if (opengl_version() < kVersion) return;
    has_opengl = ImGui_ImplOpenGL3_Init("#version 330 core");
}

void PluginEditor::State::destroy() {
    if (std::exchange(has_opengl, false)) ImGui_ImplOpenGL3_Shutdown();
}

PuglStatus PluginEditor::State::handle(const PuglEvent& event) {
    ImGui::SetCurrentContext(context);
    switch (event.type) {
        case PUGL_CREATE:
            create();
            break;
        case PUGL_DESTROY:
            destroy();
            break;
        case PUGL_CONFIGURE:
            size = {event.configure.width, event.configure.height};
            frames_due = kFramesOfEvent;
            break;
        case PUGL_UPDATE:
        case PUGL_TIMER:
            if (panel.follow() || frames_due > 0 || mouse.pending()) puglPostRedisplay(view);
            break;
        case PUGL_EXPOSE:
            if (has_opengl) draw();
            break;
        default:
            handle_mouse(event);
    }
    return PUGL_SUCCESS;
}

void PluginEditor::State::handle_mouse(const PuglEvent& event) {
    constexpr std::uint32_t kButtons = 3;
    const auto at = [](const auto& e) {
        return ImVec2{static_cast<float>(e.x), static_cast<float>(e.y)};
    };
    switch (event.type) {
        case PUGL_BUTTON_PRESS:
        case PUGL_BUTTON_RELEASE:
            mouse_at = at(event.button);
            if (event.button.button < kButtons)
                mouse.add(static_cast<int>(event.button.button), event.type == PUGL_BUTTON_PRESS,
                          mouse_at.x, mouse_at.y);
            break;
        case PUGL_MOTION:
            mouse_at = at(event.motion);
            break;
        case PUGL_SCROLL:
            ImGui::GetIO().MouseWheel += static_cast<float>(event.scroll.dy);
            break;
        case PUGL_POINTER_OUT:
        case PUGL_POINTER_IN:
            break;
        default:
            return;
    }
    frames_due = kFramesOfEvent;
}

void PluginEditor::State::draw() {
    ImGuiIO& io = ImGui::GetIO();
    const double now_s = puglGetTime(world);
    io.DeltaTime = static_cast<float>(std::clamp(now_s - drawn_s, 1e-3, 1.0));
    drawn_s = now_s;
    io.DisplaySize = {static_cast<float>(size.width), static_cast<float>(size.height)};
    // One press or release in each frame; the position is that of the event.
    const MouseEvents::Mouse now = mouse.take();
    std::copy(now.down.begin(), now.down.end(), io.MouseDown);
    io.MousePos = now.at ? ImVec2{(*now.at)[0], (*now.at)[1]} : mouse_at;
    frames_due = now.at ? kFramesOfEvent : frames_due - 1;

    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    panel.draw();
    ImGui::Render();
    clear_picture(static_cast<int>(size.width), static_cast<int>(size.height));
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool PluginEditor::is_built() { return true; }

PluginEditor::PluginEditor(EditorHost& host) : state_(std::make_unique<State>(host)) {
    if (!opens_display())
        throw Failure("the editor cannot be opened: there is no display with OpenGL");
    State& s = *state_;
    s.world = puglNewWorld(PUGL_MODULE, 0);
    if (s.world == nullptr) throw Failure("the editor cannot be opened: there is no display");
    puglSetClassName(s.world, window_class().c_str());
    s.view = puglNewView(s.world);
    s.scale = static_cast<float>(puglGetScaleFactor(s.view));
    s.size = scaled(kFirst, s.scale);
    ImGuiContext* const before = ImGui::GetCurrentContext();
    s.context = ImGui::CreateContext();
    ImGui::SetCurrentContext(s.context);
    ImGui::GetIO().IniFilename = nullptr;
    set_style(s.scale);
    load_fonts(s.scale);
    ImGui::SetCurrentContext(before);
    puglSetHandle(s.view, &s);
    puglSetEventFunc(s.view, [](PuglView* view, const PuglEvent* event) {
        try {
            return static_cast<State*>(puglGetHandle(view))->handle(*event);
        } catch (const std::exception&) {
            // Of the file system, while folders are listed. pugl is C.
            return PUGL_FAILURE;
        }
    });
    puglSetBackend(s.view, puglGlBackend());
    puglSetViewHint(s.view, PUGL_CONTEXT_VERSION_MAJOR, kVersion / 10);
    puglSetViewHint(s.view, PUGL_CONTEXT_VERSION_MINOR, kVersion % 10);
    puglSetViewHint(s.view, PUGL_USE_COMPAT_PROFILE, PUGL_FALSE);
    puglSetViewHint(s.view, PUGL_RESIZABLE, PUGL_TRUE);
    // A visual with alpha may have another depth than the window of the host.
    puglSetViewHint(s.view, PUGL_ALPHA_BITS, 0);
    // The thread of a host does not wait for the screen.
    puglSetViewHint(s.view, PUGL_SWAP_INTERVAL, 0);
}

PluginEditor::~PluginEditor() {
    State& s = *state_;
    const HostGuard guard;
    puglFreeView(s.view);
    ImGui::SetCurrentContext(s.context);
    s.destroy();  // if the window was already gone
    ImGui::DestroyContext(s.context);
    puglFreeWorld(s.world);
}

EditorSize PluginEditor::size() const { return state_->size; }

EditorSize PluginEditor::allowed(EditorSize wanted) const {
    const EditorSize least = scaled(kLeast, state_->scale);
    return {std::clamp(wanted.width, least.width, kGreatest),
            std::clamp(wanted.height, least.height, kGreatest)};
}

void PluginEditor::resize(EditorSize size) {
    const HostGuard guard;
    state_->size = allowed(size);
    puglSetSize(state_->view, state_->size.width, state_->size.height);
}

void PluginEditor::open(std::uintptr_t parent) {
    const HostGuard guard;
    State& s = *state_;
    puglSetParentWindow(s.view, parent);
    puglSetSize(s.view, s.size.width, s.size.height);
    if (puglRealize(s.view) != PUGL_SUCCESS || !s.has_opengl)
        throw Failure("the editor cannot be opened: OpenGL 3.3 is needed");
    if (kWindowSystem.has_timers && puglStartTimer(s.view, 0, 1e-3 * kPeriod_ms) != PUGL_SUCCESS)
        throw Failure("the editor cannot be opened: Windows has no timer for it");
    s.panel.follow();  // for the first picture
}

std::uintptr_t PluginEditor::window() const { return puglGetNativeView(state_->view); }

void PluginEditor::show() {
    const HostGuard guard;
    puglShow(state_->view);
}

void PluginEditor::hide() {
    const HostGuard guard;
    puglHide(state_->view);
}

void PluginEditor::idle() {
    const HostGuard guard;
    // Mesa's llvmpipe crashes if it draws to a window that the host has destroyed.
    if (!is_window(puglGetNativeWorld(state_->world), window())) return;
    puglUpdate(state_->world, 0);
}

}  // namespace aula::plugin
