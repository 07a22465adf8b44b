#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace aula::plugin {

/// The names of the window system in plugin formats, and what its windows have.
struct WindowSystem {
    const char* clap_api;
    const char* vst3_platform;
    /// Windows have timers of their own. Without them the host calls PluginEditor::idle().
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

/// The name of the class of windows. On Windows it is that of this binary only: the function of a
/// class is that of the binary that has registered it.
std::string window_class();

/// The folder of the user, or an empty path.
std::filesystem::path home_folder();

/// Those of Windows, such as "C:\\"; else none.
std::vector<std::filesystem::path> drives();

/// The version of OpenGL of the present context, 10 times the major version and the minor one.
int opengl_version();

/// Clears the present context, of so many pixels.
void clear_picture(int width, int height);

/// Whether a window exists; `world`: the connection to the window system. Needs a HostGuard.
bool is_window(void* world, std::uintptr_t window);

/// While alive, errors of the window system do not end the process: a host may have destroyed the
/// window that an editor is in. The keyboard remains the host's.
class HostGuard {
 public:
    HostGuard();
    ~HostGuard();
    HostGuard(const HostGuard&) = delete;
    HostGuard& operator=(const HostGuard&) = delete;

 private:
    void* previous_ = nullptr;
};

}  // namespace aula::plugin
