// The editor of a build without pugl, Dear ImGui or what the window system needs.

#include "apps/plugin/editor/plugin_editor.h"
#include "aula/exception.h"

namespace aula::plugin {

struct PluginEditor::State {};

bool PluginEditor::is_built() { return false; }

PluginEditor::PluginEditor(EditorHost&) { throw Failure("this build has no editor"); }

PluginEditor::~PluginEditor() = default;

EditorSize PluginEditor::size() const { return {}; }

EditorSize PluginEditor::allowed(EditorSize wanted) const { return wanted; }

void PluginEditor::resize(EditorSize) {}

void PluginEditor::open(std::uintptr_t) {}

std::uintptr_t PluginEditor::window() const { return 0; }

void PluginEditor::show() {}

void PluginEditor::hide() {}

void PluginEditor::idle() {}

}  // namespace aula::plugin
