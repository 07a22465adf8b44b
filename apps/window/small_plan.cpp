#include "apps/window/small_plan.h"

#include <algorithm>
#include <cmath>

#include "apps/drawing/plan_drawing.h"

namespace aula {

/// Cuts the room again when it or the height has changed, or while objects move.
void SmallPlan::follow(const Model& model, float z_m) {
    constexpr float kStep_m = 0.1F;
    const auto& objects = model.scene().objects;
    const bool moves =
        std::any_of(objects.begin(), objects.end(), [](const Object& o) { return o.path; });
    if (!moves && geometry_version_ == model.geometry_version() && std::abs(z_m - z_m_) < kStep_m)
        return;
    plan_ = floor_plan(model.rays(), z_m);
    geometry_version_ = model.geometry_version();
    z_m_ = z_m;
}

void SmallPlan::draw(const Model& model, const Pose& listener, ImVec2 corner, float longest,
                     ImDrawList& draw) {
    follow(model, listener.position.z);
    const glm::vec2 size_m = plan_.max - plan_.min;
    if (!(size_m.x > 0 && size_m.y > 0)) return;
    const float margin = 0.7F * ImGui::GetFontSize();
    const float scale = longest / std::max(size_m.x, size_m.y);
    const ImVec2 low{corner.x - scale * size_m.x - 2 * margin, corner.y};
    draw.AddRectFilled(low, {corner.x, corner.y + scale * size_m.y + 2 * margin},
                       packed({0.05F, 0.06F, 0.08F}, 0.8F), 4);
    const PlanDrawing drawing(plan_, {low.x + margin, low.y + margin}, scale);
    drawing.draw_walls(draw);
    const auto& sources = model.status().sources;
    for (std::size_t s = 0; s < sources.size(); ++s)
        drawing.draw_source(glm::vec2(sources[s]),
                            model.controls().audible(s) ? kSourceColour : Colour(0.45F), draw);
    drawing.draw_listener(glm::vec2(listener.position),
                          {std::cos(listener.yaw_rad), std::sin(listener.yaw_rad)}, draw);
}

}  // namespace aula
