#include <windows.h>

#include <GL/gl.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "apps/plugin/editor/window_system.h"

namespace aula::plugin {

// Opening a window fails on a system without OpenGL 3.3.
bool opens_display() { return true; }

std::string window_class() {
    static const char of_this_binary = 0;
    std::array<char, 32> name;
    std::snprintf(name.data(), name.size(), "Aula %p", static_cast<const void*>(&of_this_binary));
    return name.data();
}

std::filesystem::path home_folder() {
    const wchar_t* const home = _wgetenv(L"USERPROFILE");
    return home != nullptr ? home : L"";
}

std::vector<std::filesystem::path> drives() {
    std::vector<std::filesystem::path> found;
    const DWORD present = GetLogicalDrives();  // a bit for each letter
    for (wchar_t letter = L'A'; letter <= L'Z'; ++letter)
        if ((present >> (letter - L'A') & 1) != 0) found.push_back(std::wstring{letter} + L":\\");
    return found;
}

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

bool is_window(void*, std::uintptr_t window) {
    return IsWindow(reinterpret_cast<HWND>(window)) != 0;
}

// Calls for a window that is gone only fail. A window that is shown takes the keyboard.
HostGuard::HostGuard() : previous_(GetFocus()) {}
HostGuard::~HostGuard() {
    if (GetFocus() != previous_) SetFocus(static_cast<HWND>(previous_));
}

}  // namespace aula::plugin
