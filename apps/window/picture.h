#pragma once

#include <imgui.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "apps/window/gl/view3d.h"
#include "apps/window/model/model.h"
#include "apps/window/panels.h"
#include "apps/window/small_plan.h"
#include "apps/window/view/camera.h"
#include "apps/window/view/layout.h"
#include "apps/window/view/map_cells.h"
#include "apps/window/view/patch_field.h"

namespace aula {

/// The 3D picture of the scene (room, sources, listener, rays, energies) and its mouse interaction.
class Picture {
 public:
    Camera camera;

    /// Handles the mouse: turns the view, drags sources and listener, picks surfaces.
    void interact(Model& model, const Box& area, const Choices& choices);

    /// Draws the scene with OpenGL. `scale`: framebuffer pixels per window unit; `height`: of the
    /// framebuffer in pixels; `dt_s`: time since the last frame.
    void draw(Model& model, const Box& area, const Choices& choices, float scale, int height,
              double dt_s);

    /// Draws names, symbols and legends over the picture of draw().
    void draw_labels(const Model& model, const Box& area, const Choices& choices);

 private:
    /// The object that the pressed left button moves.
    struct DragTarget {
        enum class Kind { nothing, view, source, listener };
        Kind what = Kind::nothing;
        std::size_t source = 0;
        bool moved = false;
    };

    Screen screen(const Model& model, const Box& area) const;
    Pose listener(const Model& model) const;
    DragTarget target_at(const Model& model, const Screen& screen, const ImVec2& mouse) const;
    void drag(Model& model, const Screen& screen, const ImGuiIO& io);
    void pick(Model& model, const Screen& screen, const ImVec2& mouse, bool cut_away) const;
    bool is_hidden(const Model& model, const Vec3& point) const;
    void follow_scene(Model& model);
    void follow_size(const Model& model, const Box& area);
    void follow_patches(Model& model, const Choices& choices, double dt_s);
    void follow_map(const Model& model, const Choices& choices);
    bool follow_tone(const Model& model, const Choices& choices);
    std::string map_title(const Model& model, const ParameterText& text) const;
    std::string wave_title(const Model& model) const;
    void draw_map_scale(const Model& model, const Screen& projection, ImVec2 corner,
                        ImDrawList& draw) const;
    void add_lines(const Model& model, const Choices& choices);
    void add_lobes(const Model& model, const Screen& projection, const Choices& choices);
    void draw_sources(const Model& model, const Screen& projection, ImDrawList& draw) const;
    void draw_listener(const Model& model, const Screen& projection, ImDrawList& draw) const;
    void draw_legends(const Model& model, const Screen& projection, const Box& area,
                      const Choices& choices, ImDrawList& draw) const;
    void draw_direct_paths(const Model& model, const Screen& projection, ImDrawList& draw) const;

    View3d view_;
    PatchField field_;
    std::shared_ptr<const MappedRoom> map_;  ///< of the cells
    MapChoice map_choice_;                   ///< of the cells
    /// The tone of the standing waves of the cells.
    struct Tone {
        std::shared_ptr<const StandingWaves> waves;  ///< null: a map, or nothing, is shown
        Vec3 source{0};
        float hz = 0;
        friend bool operator==(const Tone&, const Tone&) = default;
    };
    Tone tone_;
    std::optional<MapCells> cells_;  ///< of the map or the standing waves that are shown
    std::vector<std::uint8_t> sides_;
    std::uint64_t geometry_version_ = 0;
    std::uint64_t scene_version_ = 0;
    std::uint32_t picked_ = kNoTriangle;
    float field_patch_m_ = 0;
    double pulse_s_ = 0;
    float overlay_opacity_ = 0;
    DragTarget drag_target_;
    SmallPlan plan_;
    bool shows_all_ = true;    ///< the user has not changed the view
    glm::vec2 shown_size_{0};  ///< to which the view fits
};

}  // namespace aula
