#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/drawing/input_events.h"

struct GLFWwindow;

namespace aula {

/// The GLFW library, initialised while alive. Its error messages are discarded.
class Glfw {
 public:
    Glfw();
    ~Glfw();
    Glfw(const Glfw&) = delete;
    Glfw& operator=(const Glfw&) = delete;
    bool started() const { return started_; }

 private:
    bool started_ = false;
};

/// True if a window with OpenGL 3.3 can be opened.
bool opens_window();

/// A window with an OpenGL context, and its queued input events.
class NativeWindow {
 public:
    /// A window of a size in screen coordinates, or as large as the display if that does not fit
    /// or is 0. Throws Failure if no window with OpenGL 3.3 can be opened.
    NativeWindow(int width, int height);
    ~NativeWindow();
    NativeWindow(const NativeWindow&) = delete;
    NativeWindow& operator=(const NativeWindow&) = delete;

    static constexpr int kMinWidth = 640;
    static constexpr int kMinHeight = 426;

    GLFWwindow* get() const { return window_; }
    bool software() const { return software_; }  ///< software rendering (llvmpipe)
    /// Sets the title if it has changed.
    void set_title(const std::string& title);
    bool is_active() const;  ///< has the focus, or contains the mouse

    /// A press or release of a key.
    struct KeyEvent {
        int key;
        bool pressed;
        bool control;  ///< the control key is held
        double time_s;
    };
    std::vector<KeyEvent> take_keys() { return std::exchange(keys_, {}); }
    MouseEvents& mouse() { return mouse_; }
    /// Paths of files dropped onto the window since the last call.
    std::vector<std::string> take_dropped() { return std::exchange(dropped_, {}); }

 private:
    static NativeWindow& of(GLFWwindow* window);

    GLFWwindow* window_;
    bool software_ = false;
    std::vector<KeyEvent> keys_;
    MouseEvents mouse_;
    float mouse_x_ = 0;
    float mouse_y_ = 0;
    std::vector<std::string> dropped_;
    std::string title_;
};

/// Dear ImGui in a window while alive. Fonts by index: 0 text, 1 headings, 2 small text.
class Gui {
 public:
    explicit Gui(const NativeWindow& window);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// Content scale of the display.
    float display_scale() const;

    /// Sets the scale of text and widgets. Call it between two frames.
    void set_scale(float scale);

    /// Begins a frame with the next mouse event, if any.
    void begin_frame(MouseEvents& mouse);

 private:
    GLFWwindow* window_;
    float scale_ = 0;
};

}  // namespace aula
