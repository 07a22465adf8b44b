#pragma once

namespace aula {

/// Sets the colours and sizes of Dear ImGui's present context.
void set_style(float scale);

/// Loads its fonts. By index: 0 text, 1 headings, 2 small text.
void load_fonts(float scale);

}  // namespace aula
