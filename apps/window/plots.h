#pragma once

#include <imgui.h>

#include "apps/window/model/model.h"
#include "apps/window/view/layout.h"

namespace aula {

/// Options of the plots.
struct PlotChoice {
    std::size_t band = kAllBands;
    bool early = false;            ///< only the first 150 ms
    PaneOrder order = kPaneOrder;  ///< the panes to show first if not all fit
};

/// Draws impulse response, energy response, decay curves and the table of room-acoustic parameters
/// side by side into the current Dear ImGui window.
void draw_plots(const Model& model, PlotChoice& choice);

}  // namespace aula
