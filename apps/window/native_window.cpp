#include "apps/window/native_window.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "apps/drawing/style.h"
#include "aula/exception.h"

namespace aula {

/// GLFW, or null where it or X11 is missing: then none of its functions may be called.
void* load_glfw();

namespace {

void ignore_error(int, const char*) {}

GLFWwindow* open_window(int width, int height, bool visible, bool maximized = false) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_MAXIMIZED, maximized ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_SAMPLES, 4);
    glfwWindowHint(GLFW_VISIBLE, visible ? GLFW_TRUE : GLFW_FALSE);
    return glfwCreateWindow(width, height, "Aula", nullptr, nullptr);
}

GLFWwindow* open_on_display(int width, int height) {
    int x = 0;
    int y = 0;
    int display_width = width;
    int display_height = height;
    if (GLFWmonitor* const display = glfwGetPrimaryMonitor(); display != nullptr)
        glfwGetMonitorWorkarea(display, &x, &y, &display_width, &display_height);
    if (width > 0 && height > 0 && width <= display_width && height <= display_height)
        return open_window(width, height, true);
    // Window managers maximize it. Without one it has the display's size.
    return open_window(std::max(display_width, NativeWindow::kMinWidth),
                       std::max(display_height, NativeWindow::kMinHeight), true, true);
}

}  // namespace

Glfw::Glfw() {
    if (load_glfw() == nullptr) return;
    glfwSetErrorCallback(ignore_error);
#ifdef GLFW_PLATFORM
    // Where there is no session of Wayland its library would write a line to standard error.
    if (std::getenv("WAYLAND_DISPLAY") == nullptr) glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
#endif
    started_ = glfwInit() == GLFW_TRUE;
}

Glfw::~Glfw() {
    if (started_) glfwTerminate();
}

bool opens_window() {
    const Glfw glfw;
    if (!glfw.started()) return false;
    GLFWwindow* window = open_window(16, 16, false);
    if (window == nullptr) return false;
    glfwDestroyWindow(window);
    return true;
}

NativeWindow::NativeWindow(int width, int height) : window_(open_on_display(width, height)) {
    if (window_ == nullptr)
        throw Failure("the window cannot be opened; --no-window plays in the terminal");
    glfwSetWindowUserPointer(window_, this);
    glfwSetWindowSizeLimits(window_, kMinWidth, kMinHeight, GLFW_DONT_CARE, GLFW_DONT_CARE);
    // Events are queued as they arrive: a frame may take longer than a tap.
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
        if (action == GLFW_REPEAT) return;
        of(window).keys_.push_back(
            {key, action == GLFW_PRESS, (modifiers & GLFW_MOD_CONTROL) != 0, glfwGetTime()});
    });
    // glfwGetCursorPos() returns the present position, not that of the click.
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
        of(window).mouse_x_ = static_cast<float>(x);
        of(window).mouse_y_ = static_cast<float>(y);
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
        of(window).mouse_.add(button, action == GLFW_PRESS, of(window).mouse_x_,
                              of(window).mouse_y_);
    });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** names) {
        of(window).dropped_.insert(of(window).dropped_.end(), names, names + count);
    });
    glfwMakeContextCurrent(window_);
    if (epoxy_gl_version() < 33)
        throw Failure("OpenGL 3.3 cannot be used; --no-window plays in the terminal");
    const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    software_ = renderer != nullptr && std::strstr(renderer, "llvmpipe") != nullptr;
    glfwSwapInterval(software_ ? 0 : 1);
}

NativeWindow::~NativeWindow() { glfwDestroyWindow(window_); }

void NativeWindow::set_title(const std::string& title) {
    if (std::exchange(title_, title) != title) glfwSetWindowTitle(window_, title.c_str());
}

bool NativeWindow::is_active() const {
    return glfwGetWindowAttrib(window_, GLFW_FOCUSED) != 0 ||
           glfwGetWindowAttrib(window_, GLFW_HOVERED) != 0;
}

NativeWindow& NativeWindow::of(GLFWwindow* window) {
    return *static_cast<NativeWindow*>(glfwGetWindowUserPointer(window));
}

Gui::Gui(const NativeWindow& window) : window_(window.get()) {
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui_ImplGlfw_InitForOpenGL(window_, true);
    ImGui_ImplOpenGL3_Init("#version 330 core");
}

float Gui::display_scale() const {
    float scale = 1;
    float unused = 1;
    glfwGetWindowContentScale(window_, &scale, &unused);
    return scale;
}

void Gui::set_scale(float scale) {
    if (scale == scale_) return;
    scale_ = scale;
    set_style(scale);
    load_fonts(scale);
    // The next frame makes them again; without the fonts' texture alone it would not.
    ImGui_ImplOpenGL3_DestroyDeviceObjects();
}

void Gui::begin_frame(MouseEvents& mouse) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGuiIO& io = ImGui::GetIO();
    const MouseEvents::Mouse now = mouse.take();
    std::copy(now.down.begin(), now.down.end(), io.MouseDown);
    if (now.at) io.MousePos = {(*now.at)[0], (*now.at)[1]};
    ImGui::NewFrame();
}

Gui::~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

}  // namespace aula
