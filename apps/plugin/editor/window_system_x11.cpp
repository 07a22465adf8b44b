#include "apps/plugin/editor/window_system.h"

#include <epoxy/gl.h>
#include <epoxy/glx.h>

#include <cstdlib>

namespace aula {

/// Xlib, or null where it is missing: then none of its functions may be called.
void* load_x11();

namespace plugin {

bool opens_display() {
    if (load_x11() == nullptr) return false;
    ::Display* const display = XOpenDisplay(nullptr);
    if (display == nullptr) return false;
    const bool has_opengl = epoxy_has_glx(display);
    XCloseDisplay(display);
    return has_opengl;
}

std::string window_class() { return "Aula"; }

std::filesystem::path home_folder() {
    const char* const home = std::getenv("HOME");
    return home != nullptr ? home : "";
}

std::vector<std::filesystem::path> drives() { return {}; }

int opengl_version() { return epoxy_gl_version(); }

void clear_picture(int width, int height) {
    glViewport(0, 0, width, height);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

bool is_window(void* world, std::uintptr_t window) {
    XWindowAttributes attributes;
    return XGetWindowAttributes(static_cast<::Display*>(world), window, &attributes) != 0;
}

// Those of a connection arrive while its owner calls Xlib: the handler sees no others than those of
// the editor, but for other threads.
HostGuard::HostGuard()
    : previous_(
          reinterpret_cast<void*>(XSetErrorHandler([](::Display*, XErrorEvent*) { return 0; }))) {}

HostGuard::~HostGuard() { XSetErrorHandler(reinterpret_cast<XErrorHandler>(previous_)); }

}  // namespace plugin

}  // namespace aula
