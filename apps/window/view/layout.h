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

/// All panes, those to show first if not all fit.
using PaneOrder = std::array<Pane, kPanes.size()>;
inline constexpr PaneOrder kPaneOrder{Pane::parameters, Pane::decay, Pane::response, Pane::energy,
                                      Pane::walk};

/// The order in which a pane is the first, and the others follow as before.
PaneOrder with_first(Pane first, PaneOrder order);

struct PaneBox {
    Pane pane;
    float width;
};

/// The panes shown side by side in the strip, from left to right as in kPanes: the first ones of
/// the order, as many as fit and at least one.
std::vector<PaneBox> panes_in(float width, float em, float gap, const PaneOrder& order);

/// Text size relative to that of a window of 1600 x 1000 or smaller: the larger of the window's
/// relative size and the display's content scale, at least 1, times the user's factor `zoom`.
float text_scale(float width, float height, float display_scale, float zoom);

}  // namespace aula
