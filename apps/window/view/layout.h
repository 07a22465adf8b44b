#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace aula {

/// A rectangle in window coordinates, from the upper left corner.
struct Box {
    float x = 0;
    float y = 0;
    float width = 0;
    float height = 0;

    bool contains(float px, float py) const {
        return px >= x && py >= y && px < x + width && py < y + height;
    }
};

/// The parts of the window. They cover it without overlap.
struct Layout {
    Box bar;
    Box picture;
    Box plots;
    Box controls;
    Box meters;
};

/// `em` is the text height, `meters_height` the height of the meters' content.
Layout window_layout(float width, float height, float em, float meters_height);

/// The panes of the strip below the picture.
enum class Pane { response, energy, decay, parameters, walk };
inline constexpr std::array<Pane, 5> kPanes{Pane::response, Pane::energy, Pane::decay,
                                            Pane::parameters, Pane::walk};

struct PaneBox {
    Pane pane;
    float width;
};

/// The panes shown side by side in the strip: all if they fit; otherwise as many as fit, from
/// `first` on and at least one.
std::vector<PaneBox> panes_in(float width, float em, float gap, Pane first);

/// Text size relative to that of a window of 1280 x 800: the larger of the window's relative size
/// and the display's content scale, at least 1, times the user's factor `zoom`.
float text_scale(float width, float height, float display_scale, float zoom);

}  // namespace aula
