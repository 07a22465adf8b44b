#include "apps/drawing/plan_drawing.h"

#include <cmath>
#include <glm/common.hpp>

namespace aula {

ImU32 packed(const glm::vec3& colour, float alpha) {
    return ImGui::ColorConvertFloat4ToU32({colour.x, colour.y, colour.z, alpha});
}

ImVec2 PlanDrawing::at(const glm::vec2& point) const {
    const glm::vec2 inside = glm::clamp(point, section_.min, section_.max);
    return {low_.x + scale_ * (inside.x - section_.min.x),
            low_.y + scale_ * (section_.max.y - inside.y)};
}

glm::vec2 PlanDrawing::point(ImVec2 pixel) const {
    return {section_.min.x + (pixel.x - low_.x) / scale_,
            section_.max.y - (pixel.y - low_.y) / scale_};
}

ImVec2 PlanDrawing::size() const {
    const glm::vec2 size = scale_ * (section_.max - section_.min);
    return {size.x, size.y};
}

void PlanDrawing::draw_walls(ImDrawList& draw) const {
    constexpr float kShortest = 0.5F;  // of a line, in pixels
    for (const auto& wall : section_.walls) {
        const ImVec2 from = at(wall[0]);
        const ImVec2 to = at(wall[1]);
        if (std::abs(from.x - to.x) + std::abs(from.y - to.y) < kShortest) continue;
        draw.AddLine(from, to, packed({0.80F, 0.84F, 0.90F}));
    }
}

void PlanDrawing::draw_source(const glm::vec2& place, const glm::vec3& colour,
                              ImDrawList& draw) const {
    draw.AddCircleFilled(at(place), 0.3F * ImGui::GetFontSize(), packed(colour));
}

void PlanDrawing::draw_listener(const glm::vec2& place, const glm::vec2& direction,
                                ImDrawList& draw) const {
    const float em = ImGui::GetFontSize();
    const ImVec2 centre = at(place);
    const ImU32 colour = packed(kListenerColour);
    if (direction == glm::vec2(0)) return draw.AddCircleFilled(centre, 0.5F * em, colour);
    const float turn = -std::atan2(direction.y, direction.x);  // the picture's y points down
    const auto beside = [&](float angle_rad, float distance) {
        return ImVec2{centre.x + distance * std::cos(turn + angle_rad),
                      centre.y + distance * std::sin(turn + angle_rad)};
    };
    constexpr float kWing_rad = 2.5F;
    draw.AddTriangleFilled(beside(0, 0.8F * em), beside(kWing_rad, 0.5F * em),
                           beside(-kWing_rad, 0.5F * em), colour);
}

}  // namespace aula
