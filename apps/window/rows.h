#pragma once

#include <imgui.h>

#include <functional>
#include <initializer_list>
#include <string>

#include "apps/window/gl/colours.h"

namespace aula {

// Rows of the panels at the side: names, controls and values stand in three columns, so that no
// text covers a control.

/// Draws a name, the value at the right and the control between them. `control` draws the item with
/// the given label, of the width that is set, and returns whether it has changed. Without a value
/// the item takes its column, too. The control is the last item afterwards.
bool row(const char* name, const char* meaning, const std::string& value,
         const std::function<bool(const char* label)>& control);

/// A slider without its number, which row() shows beside it. Ctrl and a click edit the number.
bool bare_slider(const char* label, float* value, float from, float to, const char* format,
                 ImGuiSliderFlags flags = 0);
bool bare_slider(const char* label, int* value, int from, int to, ImGuiSliderFlags flags = 0);

/// A name and a text.
void text_row(const char* name, const char* meaning, const std::string& text);

/// A part of a bar.
struct BarPart {
    double share;  ///< of the bar's length, 0..1
    Colour colour;
};

/// A bar of adjacent parts, with a mark if `mark` is not negative.
void bar_row(const char* name, const char* meaning, const std::string& value,
             std::initializer_list<BarPart> parts, double mark = -1);

/// Continues the line if a small button with the label fits.
void same_line_for(const char* label);

/// Shows a text beside the panel while the mouse rests on the last item: over the picture, where it
/// covers no control.
void tooltip(const char* text);

}  // namespace aula
