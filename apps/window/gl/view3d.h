#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <span>
#include <vector>

#include "apps/window/gl/colours.h"
#include "apps/window/gl/gl_objects.h"
#include "apps/window/view/map_cells.h"
#include "apps/window/view/patch_field.h"
#include "aula/engine/frame.h"
#include "aula/engine/scene.h"
#include "engine/rays/ray_scene.h"

namespace aula {

/// Drawing style of the room.
struct RoomStyle {
    bool solid = true;
    bool edges = true;
    bool cut_away = true;       ///< omits sides that face away from the sound field
    float overlay_opacity = 0;  ///< of the patches' energies, 0..1
    bool first_person = false;  ///< darkens far walls and strengthens edges
    float stripe_pixels = 16;   ///< distance of the stripes over the selected surface
};

/// Draws the room, the energies of its patches and lines, with OpenGL.
class View3d {
 public:
    View3d();
    ~View3d();
    View3d(const View3d&) = delete;
    View3d& operator=(const View3d&) = delete;

    /// Uploads the triangles at their present positions. `sides`: of interior_sides().
    void set_room(const Scene& scene, const RayScene& rays, std::span<const std::uint8_t> sides);

    /// Uploads the present positions of moving triangles; materials and sides stay.
    void move_room(const RayScene& rays);

    /// Uploads the energies of the patches.
    void set_patches(const PatchField& field);

    /// Marks triangles by stripes and an outline, between which their colours are seen.
    void set_picked(const RayScene& rays, std::span<const std::uint32_t> triangles);

    /// The map to draw in the room; null: none.
    void set_map(const MapCells* map);

    /// Adds a line to the next draw() only. Alpha 0..1 at both ends.
    void add_line(const Vec3& from, const Vec3& to, const Colour& colour, float from_alpha,
                  float to_alpha);
    void add_rays(const std::vector<PathLine>& lines);

    /// Adds edges that diffract sound, in three shades: free edges, bends above 40 degrees, others.
    void add_edges(const std::vector<EdgeLine>& edges);

    /// Draws into a rectangle of the framebuffer, in pixels from its lower left corner.
    void draw(const glm::mat4& matrix, const Vec3& eye, const RoomStyle& style, int x, int y,
              int width, int height);

 private:
    void make_vertices(const RayScene& rays);
    void make_edges(const RayScene& rays);

    GlProgram room_program_;
    GlProgram edge_program_;
    GlProgram line_program_;
    GlProgram pick_program_;
    GlVertices room_{3, 3, 3, 3};
    GlVertices edges_{3, 3, 3, 2};
    GlVertices lines_{3, 4};
    GlVertices picked_{3, 4};
    GlVertices picked_outline_{3, 4};
    GlVertices map_{3, 4};
    std::vector<MaterialLook> looks_;  ///< [triangle]
    std::vector<std::uint8_t> sides_;  ///< [triangle]
    std::vector<float> scratch_;
    std::vector<float> line_data_;
    GLuint field_texture_ = 0;
    GLuint palette_texture_ = 0;
    glm::ivec3 field_size_{1};
    Vec3 field_origin_{0};
    float field_cell_m_ = 1;
    bool has_field_ = false;
};

}  // namespace aula
