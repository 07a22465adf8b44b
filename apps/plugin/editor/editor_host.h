#pragma once

#include <filesystem>
#include <string>

#include "apps/plugin/plugin_room.h"

namespace aula::plugin {

/// What an editor shows and changes: an instance, directly or through its host. [main thread]
class EditorHost {
 public:
    EditorHost() = default;
    virtual ~EditorHost() = default;
    EditorHost(const EditorHost&) = delete;
    EditorHost& operator=(const EditorHost&) = delete;

    virtual std::size_t sources() const = 0;
    /// Of the scenes that ship with the plugins.
    virtual std::filesystem::path folder() const = 0;

    virtual ControlValues values() const = 0;
    virtual RoomFiles files() const = 0;
    /// Peak of the output, dB re full scale.
    virtual float level_db() const = 0;
    /// An error's line, or what the user should know; empty: nothing.
    virtual std::string status() const = 0;

    // A movement of the mouse changes controls between these two.
    virtual void begin_change(Control control) = 0;
    virtual void end_change(Control control) = 0;

    virtual void change(Control control, float value) = 0;
    /// Makes a file the scene of the state.
    virtual void choose_scene(const std::filesystem::path& file) = 0;
};

}  // namespace aula::plugin
