#pragma once

#include <cstdint>

#include "apps/plugin/controls.h"

namespace aula::test {

/// A host of the editor of a plugin in a format, with the default room.
class EditorFormat {
 public:
    EditorFormat() = default;
    virtual ~EditorFormat() = default;
    EditorFormat(const EditorFormat&) = delete;
    EditorFormat& operator=(const EditorFormat&) = delete;

    /// In a window of the host; false if the plugin refuses.
    virtual bool open(std::uintptr_t parent) = 0;
    virtual void idle() = 0;
    virtual void close() = 0;

    /// The value that the plugin has.
    virtual double get(plugin::Control control) const = 0;
    virtual void set(plugin::Control control, double value) = 0;

    /// The last value that the editor has told the host.
    virtual double told(plugin::Control control) const = 0;
    /// Gestures that have begun and not ended, and that have ended.
    virtual int gestures() const = 0;
    virtual int ended_gestures() const = 0;

    /// How often the host has been told that its project has changed beside the controls.
    virtual int told_changes() const { return 0; }
};

}  // namespace aula::test
