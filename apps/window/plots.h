#pragma once

#include <imgui.h>

#include "apps/window/model/layout.h"
#include "apps/window/model/model.h"

namespace aula {

/// How the plots show what there is.
struct PlotChoice {
    std::size_t band = kAllBands;
    bool early = false;           ///< only the first 150 ms
    Pane first = Pane::response;  ///< where not all have room
};

/// Impulse response, energy response, decay curves and the table of room-acoustic parameters, side
/// by side in the current window.
void draw_plots(const Model& model, PlotChoice& choice);

/// A colour as Dear ImGui packs it.
ImU32 packed(const glm::vec3& colour, float alpha = 1);

}  // namespace aula
