#include <windows.h>

#include <GL/gl.h>

#include <cstdio>

#include "apps/plugin/editor/window_system.h"

namespace aula::plugin {

// What a system without OpenGL lacks is seen when a window is opened.
bool opens_display() { return true; }

int opengl_version() {
    const auto* const text = reinterpret_cast<const char*>(glGetString(GL_VERSION));
    int major = 0;
    int minor = 0;
    if (text == nullptr || std::sscanf(text, "%d.%d", &major, &minor) != 2) return 0;
    return 10 * major + minor;
}

void clear_picture(int width, int height) {
    glViewport(0, 0, width, height);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

// Windows has none: calls for a window that is gone fail.
IgnoredErrors::IgnoredErrors() = default;
IgnoredErrors::~IgnoredErrors() = default;

}  // namespace aula::plugin
