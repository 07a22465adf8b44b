#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/window/model/input_events.h"

struct GLFWwindow;

namespace aula {

/// GLFW while alive; silent.
class Glfw {
 public:
    Glfw();
    ~Glfw();
    Glfw(const Glfw&) = delete;
    Glfw& operator=(const Glfw&) = delete;
    bool started() const { return started_; }

 private:
    bool started_;
};

/// Whether a window with OpenGL 3.3 can be opened.
bool opens_window();

/// A window with an OpenGL context, and what happened to it.
class NativeWindow {
 public:
    /// Throws AudioFailure if it cannot be opened, or has no OpenGL 3.3.
    NativeWindow(int width, int height);
    ~NativeWindow();
    NativeWindow(const NativeWindow&) = delete;
    NativeWindow& operator=(const NativeWindow&) = delete;

    static constexpr int kLeastWidth = 640;
    static constexpr int kLeastHeight = 426;

    GLFWwindow* get() const { return window_; }
    bool software() const { return software_; }  ///< drawn by the processor
    bool attended() const;                       ///< has the focus, or the mouse is over it

    /// A key that was pressed or released.
    struct KeyEvent {
        int key;
        bool pressed;
        bool control;  ///< is held, too
        double time_s;
    };
    std::vector<KeyEvent> take_keys() { return std::exchange(keys_, {}); }
    /// The mouse's presses and releases.
    MouseEvents& mouse() { return mouse_; }
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
};

/// Dear ImGui in a window while alive. Its fonts are text, headings, small text: in this order.
class Gui {
 public:
    explicit Gui(const NativeWindow& window);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// The display's own scale.
    float display_scale() const;

    /// Makes text and all that goes with it so many times larger. Between two frames.
    void set_scale(float scale);

    /// Begins a frame with the mouse at its next press or release, if there is one.
    void begin_frame(MouseEvents& mouse);

 private:
    GLFWwindow* window_;
    float scale_ = 0;
};

}  // namespace aula
