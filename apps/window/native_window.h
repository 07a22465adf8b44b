#pragma once

#include <string>
#include <utility>
#include <vector>

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

    GLFWwindow* get() const { return window_; }
    bool software() const { return software_; }  ///< drawn by the processor
    bool attended() const;                       ///< has the focus, or the mouse is over it

    /// A key, and whether control was held.
    struct Press {
        int key;
        bool control;
    };
    std::vector<Press> take_pressed() { return std::exchange(pressed_, {}); }
    /// Where the mouse was when its left button was last pressed; a picture later it may be far.
    float pressed_x() const { return pressed_x_; }
    float pressed_y() const { return pressed_y_; }
    std::vector<std::string> take_dropped() { return std::exchange(dropped_, {}); }

 private:
    static NativeWindow& of(GLFWwindow* window);

    GLFWwindow* window_;
    bool software_ = false;
    std::vector<Press> pressed_;
    float mouse_x_ = 0;
    float mouse_y_ = 0;
    float pressed_x_ = 0;
    float pressed_y_ = 0;
    std::vector<std::string> dropped_;
};

/// Dear ImGui in a window while alive. Its fonts are text, headings, small text: in this order.
class Gui {
 public:
    explicit Gui(const NativeWindow& window);
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;
};

}  // namespace aula
