#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace aula {

/// A rectangle of the window, in its coordinates.
struct Box {
    float x = 0;
    float y = 0;
    float width = 0;
    float height = 0;
};

/// The parts of the window, which cover it without overlaps.
struct Layout {
    Box bar;
    Box picture;
    Box plots;
    Box controls;
    Box meters;
};

/// `em` is the height of text, `meters_height` what the meters need.
Layout window_layout(float width, float height, float em, float meters_height);

/// What the strip below the picture shows.
enum class Pane { response, energy, decay, parameters };
inline constexpr std::array<Pane, 4> kPanes{Pane::response, Pane::energy, Pane::decay,
                                            Pane::parameters};

struct PaneBox {
    Pane pane;
    float width;
};

/// The panes that have room side by side: all of them where they fit, else those from `first` on,
/// at least one.
std::vector<PaneBox> panes_in(float width, float em, float gap, Pane first);

/// How many times larger than at 1280 x 800 text is: it grows with the window, and with the
/// display's own scale where that is larger. `zoom` is the user's factor.
float text_scale(float width, float height, float display_scale, float zoom);

}  // namespace aula
