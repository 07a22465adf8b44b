#pragma once

#include <imgui.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "apps/drawing/room_section.h"

namespace aula {

inline constexpr glm::vec3 kSourceColour{1.0F, 0.60F, 0.15F};
inline constexpr glm::vec3 kListenerColour{0.35F, 0.80F, 1.0F};

/// A colour in Dear ImGui's packed format.
ImU32 packed(const glm::vec3& colour, float alpha = 1);

/// Draws a section of a room: its first coordinate to the right, its second one upwards.
class PlanDrawing {
 public:
    /// `low`: the upper left corner of the room's bounds, in pixels; `scale`: pixels of a metre.
    PlanDrawing(const RoomSection& section, ImVec2 low, float scale)
        : section_(section), low_(low), scale_(scale) {}

    /// The pixel of a point, which is moved into the room's bounds.
    ImVec2 at(const glm::vec2& point) const;
    /// The point of a pixel.
    glm::vec2 point(ImVec2 pixel) const;
    ImVec2 size() const;

    void draw_walls(ImDrawList& draw) const;
    void draw_source(const glm::vec2& place, const glm::vec3& colour, ImDrawList& draw) const;
    /// An arrow that looks along `direction`; a disc if it is zero.
    void draw_listener(const glm::vec2& place, const glm::vec2& direction, ImDrawList& draw) const;

 private:
    const RoomSection& section_;
    ImVec2 low_;
    float scale_;
};

}  // namespace aula
