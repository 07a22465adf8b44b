#pragma once

#include <cstdint>
#include <memory>

#include "apps/plugin/editor/editor_host.h"

namespace aula::plugin {

/// Size of an editor, pixels.
struct EditorSize {
    unsigned width = 0;
    unsigned height = 0;
};

/// The window of a plugin, in a window of the host. [main thread]
class PluginEditor {
 public:
    /// False in a build without editors, in which the constructor throws.
    static bool is_built();

    /// Not visible yet. Throws Failure, with one line, if there is no display.
    explicit PluginEditor(EditorHost& host);
    ~PluginEditor();
    PluginEditor(const PluginEditor&) = delete;
    PluginEditor& operator=(const PluginEditor&) = delete;

    EditorSize size() const;
    /// The nearest size in which everything is readable.
    EditorSize allowed(EditorSize wanted) const;
    void resize(EditorSize size);

    /// Opens it in a window of the host, by the number of the window system. Throws Failure if that
    /// cannot be done, or without OpenGL 3.3.
    void open(std::uintptr_t parent);
    /// The number of its window.
    std::uintptr_t window() const;
    void show();
    void hide();

    /// Handles the mouse, and draws what has changed. Hosts call it every kPeriod_ms, unless the
    /// window system has_timers.
    void idle();
    static constexpr unsigned kPeriod_ms = 33;

 private:
    struct State;
    const std::unique_ptr<State> state_;
};

}  // namespace aula::plugin
