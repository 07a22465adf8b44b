#pragma once

#include <imgui.h>

#include <cstdint>

#include "apps/drawing/room_section.h"
#include "apps/window/model/model.h"

namespace aula {

/// A small plan of the room, cut at the listener's ears, with the listener and the sources.
class SmallPlan {
 public:
    /// Draws the plan with its upper right corner at `corner`. `longest` is the room's longer side.
    void draw(const Model& model, const Pose& listener, ImVec2 corner, float longest,
              ImDrawList& draw);

 private:
    void follow(const Model& model, float z_m);

    RoomSection plan_;
    std::uint64_t geometry_version_ = 0;
    float z_m_ = 0;
};

}  // namespace aula
