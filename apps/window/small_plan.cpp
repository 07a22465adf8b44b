#include "apps/window/small_plan.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "apps/window/gl/colours.h"
#include "apps/window/plots.h"

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
    constexpr float kShortest = 0.5F;  // of a line, in pixels
    follow(model, listener.position.z);
    const glm::vec2 size_m = plan_.max - plan_.min;
    if (!(size_m.x > 0 && size_m.y > 0)) return;
    const float em = ImGui::GetFontSize();
    const float margin = 0.7F * em;
    const float scale = longest / std::max(size_m.x, size_m.y);
    const glm::vec2 size = scale * size_m;
    const ImVec2 low{corner.x - size.x - 2 * margin, corner.y};
    draw.AddRectFilled(low, {corner.x, corner.y + size.y + 2 * margin},
                       packed({0.05F, 0.06F, 0.08F}, 0.8F), 4);
    // x points to the right, y upwards.
    const auto at = [&](const glm::vec2& point) {
        const glm::vec2 inside = glm::clamp(point, plan_.min, plan_.max);
        return ImVec2{low.x + margin + scale * (inside.x - plan_.min.x),
                      low.y + margin + scale * (plan_.max.y - inside.y)};
    };
    for (const auto& wall : plan_.walls) {
        const ImVec2 from = at(wall[0]);
        const ImVec2 to = at(wall[1]);
        if (std::abs(from.x - to.x) + std::abs(from.y - to.y) < kShortest) continue;
        draw.AddLine(from, to, packed({0.80F, 0.84F, 0.90F}));
    }
    const auto& sources = model.status().sources;
    for (std::size_t s = 0; s < sources.size(); ++s)
        draw.AddCircleFilled(at(glm::vec2(sources[s])), 0.3F * em,
                             packed(model.controls().audible(s) ? kSourceColour : Colour(0.45F)));
    const glm::vec2 here(listener.position);
    const ImVec2 centre = at(here);
    const float turn = -listener.yaw_rad;  // the picture's y points down
    const auto beside = [&](float angle_rad, float distance) {
        return ImVec2{centre.x + distance * std::cos(turn + angle_rad),
                      centre.y + distance * std::sin(turn + angle_rad)};
    };
    constexpr float kWing_rad = 2.5F;
    draw.AddTriangleFilled(beside(0, 0.8F * em), beside(kWing_rad, 0.5F * em),
                           beside(-kWing_rad, 0.5F * em), packed(kListenerColour));
}

}  // namespace aula
