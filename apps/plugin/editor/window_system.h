#pragma once

namespace aula::plugin {

/// Loads the libraries of the window system. False without them, without a display, or if it has no
/// OpenGL; before that nothing else may be called.
bool opens_display();

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
