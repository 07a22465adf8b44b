#pragma once

namespace aula::plugin {

/// What formats call the window system, and what its windows do.
struct WindowSystem {
    const char* clap_api;
    const char* vst3_platform;
    /// A window has a timer of its own, which the messages call that a host dispatches: the host
    /// calls PluginEditor::idle() otherwise.
    bool has_timers;
};

#if defined(_WIN32)
inline constexpr WindowSystem kWindowSystem{"win32", "HWND", true};
#else
inline constexpr WindowSystem kWindowSystem{"x11", "X11EmbedWindowID", false};
#endif

/// Loads the libraries of the window system. False without them, without a display, or if it has no
/// OpenGL; before that nothing else may be called.
bool opens_display();

/// The version of OpenGL of the present context, 10 times the major version and the minor one.
int opengl_version();

/// Clears the present context, of so many pixels.
void clear_picture(int width, int height);

/// While alive, errors of the window system do not end the process: a host may have destroyed the
/// window that an editor is in.
class IgnoredErrors {
 public:
    IgnoredErrors();
    ~IgnoredErrors();
    IgnoredErrors(const IgnoredErrors&) = delete;
    IgnoredErrors& operator=(const IgnoredErrors&) = delete;

 private:
    void (*previous_)() = nullptr;
};

}  // namespace aula::plugin
