#include "apps/window/gl/view3d.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <initializer_list>
#include <map>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "apps/window/gl/room_shaders.h"

namespace aula {

namespace {

void append(std::vector<float>& data, const Vec3& v) { data.insert(data.end(), {v.x, v.y, v.z}); }

/// A position rounded to millimetres, so that adjacent triangles share vertices.
struct RoundedPosition {
    long x, y, z;
    explicit RoundedPosition(const Vec3& v)
        : x(std::lround(v.x * 1000)), y(std::lround(v.y * 1000)), z(std::lround(v.z * 1000)) {}
    auto operator<=>(const RoundedPosition&) const = default;
};

struct EdgeHash {
    std::size_t operator()(const std::pair<RoundedPosition, RoundedPosition>& edge) const {
        std::size_t hash = 0;
        for (const RoundedPosition* p : {&edge.first, &edge.second})
            for (const long k : {p->x, p->y, p->z})
                hash = (hash ^ static_cast<std::size_t>(k)) * 0x9E3779B97F4A7C15ULL;
        return hash ^ (hash >> 29);
    }
};

}  // namespace

View3d::View3d()
    : room_program_(kRoomVertex, kRoomFragment),
      edge_program_(kEdgeVertex, kLineFragment),
      line_program_(kLineVertex, kLineFragment),
      pick_program_(kLineVertex, kPickFragment) {
    glGenTextures(1, &field_texture_);
    glGenTextures(1, &palette_texture_);
    constexpr int kSteps = 256;
    std::vector<float> palette;
    for (int i = 0; i < kSteps; ++i)
        append(palette, map_colour(static_cast<float>(i) / (kSteps - 1)));
    glBindTexture(GL_TEXTURE_2D, palette_texture_);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, kSteps, 1, 0, GL_RGB, GL_FLOAT, palette.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glBindTexture(GL_TEXTURE_2D, 0);
}

View3d::~View3d() {
    glDeleteTextures(1, &field_texture_);
    glDeleteTextures(1, &palette_texture_);
}

void View3d::make_vertices(const RayScene& rays) {
    scratch_.clear();
    // [triangle] Of faces that overlap in one plane the one that is heard is in front.
    std::vector<float> depth(rays.triangle_count(), 0);
    constexpr int kLayers = 3;  // a picture on a door on a wall
    for (int layer = 0; layer < kLayers; ++layer)
        for (const CoplanarFaces::Overlap& overlap : rays.coplanar_faces().overlaps())
            depth[overlap.covered] = std::max(depth[overlap.covered], depth[overlap.heard] + 1);
    for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = rays.triangle(t);
        for (const Vec3& v : triangle.vertices) {
            append(scratch_, v);
            append(scratch_, triangle.normal);
            append(scratch_, looks_[t].colour);
            scratch_.push_back(static_cast<float>(sides_[t]));
            scratch_.push_back(static_cast<float>(looks_[t].pattern));
            scratch_.push_back(depth[t]);
        }
    }
    room_.set(scratch_);
}

/// Edges at bends, borders and changes of material.
void View3d::make_edges(const RayScene& rays) {
    constexpr float kBend = 0.9F;  // 26 degrees
    struct Edge {
        Vec3 from, to;
        std::uint32_t first;
        std::uint32_t second;
        bool sharp;
    };
    std::unordered_map<std::pair<RoundedPosition, RoundedPosition>, Edge, EdgeHash> edges;
    for (std::uint32_t t = 0; t < rays.triangle_count(); ++t) {
        const RayScene::Triangle& triangle = rays.triangle(t);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& a = triangle.vertices[i];
            const Vec3& b = triangle.vertices[(i + 1) % 3];
            const std::pair<RoundedPosition, RoundedPosition> ends =
                std::minmax({RoundedPosition(a), RoundedPosition(b)});
            const auto [entry, added] = edges.try_emplace(ends, Edge{a, b, t, t, true});
            if (added) continue;
            Edge& edge = entry->second;
            const RayScene::Triangle& other = rays.triangle(edge.first);
            edge.sharp = edge.first != edge.second ||
                         std::abs(glm::dot(other.normal, triangle.normal)) < kBend ||
                         other.material != triangle.material;
            edge.second = t;
        }
    }
    scratch_.clear();
    for (const auto& [ends, edge] : edges) {
        if (!edge.sharp) continue;
        for (const Vec3& v : {edge.from, edge.to}) {
            append(scratch_, v);
            append(scratch_, rays.triangle(edge.first).normal);
            append(scratch_, rays.triangle(edge.second).normal);
            scratch_.push_back(static_cast<float>(sides_[edge.first]));
            scratch_.push_back(static_cast<float>(sides_[edge.second]));
        }
    }
    edges_.set(scratch_);
}

void View3d::set_room(const Scene& scene, const RayScene& rays,
                      std::span<const std::uint8_t> sides) {
    sides_.assign(sides.begin(), sides.end());
    std::vector<MaterialLook> looks;
    for (const Material& material : scene.materials) looks.push_back(material_look(material.name));
    looks_.clear();
    for (const Object& object : scene.objects)
        for (const std::uint32_t material : object.triangle_materials)
            looks_.push_back(looks[material]);
    make_vertices(rays);
    make_edges(rays);
    picked_.set({});
    picked_outline_.set({});
}

void View3d::move_room(const RayScene& rays) {
    make_vertices(rays);
    make_edges(rays);
}

void View3d::set_patches(const PatchField& field) {
    field_origin_ = field.origin();
    field_cell_m_ = field.cell_m();
    has_field_ = !field.texels().empty();
    if (!has_field_) return;
    glBindTexture(GL_TEXTURE_3D, field_texture_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const glm::ivec3 size = field.size();
    if (size == field_size_) {
        glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, size.x, size.y, 6 * size.z, GL_RG,
                        GL_UNSIGNED_BYTE, field.texels().data());
    } else {
        field_size_ = size;
        glTexImage3D(GL_TEXTURE_3D, 0, GL_RG8, size.x, size.y, 6 * size.z, 0, GL_RG,
                     GL_UNSIGNED_BYTE, field.texels().data());
        for (const GLenum filter :
             std::initializer_list<GLenum>{GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
            glTexParameteri(GL_TEXTURE_3D, filter, GL_LINEAR);
        for (const GLenum wrap :
             std::initializer_list<GLenum>{GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R})
            glTexParameteri(GL_TEXTURE_3D, wrap, GL_CLAMP_TO_EDGE);
    }
    glBindTexture(GL_TEXTURE_3D, 0);
}

void View3d::set_picked(const RayScene& rays, std::span<const std::uint32_t> triangles) {
    const Colour colour{0.25F, 0.75F, 1.0F};
    scratch_.clear();
    const auto add = [&](const Vec3& at) {
        append(scratch_, at);
        append(scratch_, colour);
        scratch_.push_back(1);
    };
    // The outline: sides that one triangle has.
    std::map<std::pair<RoundedPosition, RoundedPosition>, std::pair<std::array<Vec3, 2>, int>>
        sides;
    for (const std::uint32_t t : triangles) {
        const auto& vertices = rays.triangle(t).vertices;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3& a = vertices[i];
            const Vec3& b = vertices[(i + 1) % 3];
            const std::pair<RoundedPosition, RoundedPosition> ends =
                std::minmax({RoundedPosition(a), RoundedPosition(b)});
            auto& [line, count] = sides[ends];
            line = {a, b};
            ++count;
            add(a);
        }
    }
    picked_.set(scratch_);
    scratch_.clear();
    for (const auto& [ends, side] : sides) {
        if (side.second > 1) continue;
        for (const Vec3& end : side.first) add(end);
    }
    picked_outline_.set(scratch_);
}

void View3d::set_map(const MapCells* map) {
    constexpr float kAlpha = 0.92F;
    scratch_.clear();
    for (const MapCells::Cell& cell :
         map != nullptr ? map->cells() : std::vector<MapCells::Cell>{}) {
        const Colour colour = map->colour(cell);
        for (const glm::vec2& corner : {cell.low, glm::vec2(cell.high.x, cell.low.y), cell.high,
                                        cell.low, cell.high, glm::vec2(cell.low.x, cell.high.y)}) {
            append(scratch_, Vec3(corner, map->height_m()));
            append(scratch_, colour);
            scratch_.push_back(kAlpha);
        }
    }
    map_.set(scratch_);
}

void View3d::add_line(const Vec3& from, const Vec3& to, const Colour& colour, float from_alpha,
                      float to_alpha) {
    append(line_data_, from);
    append(line_data_, colour);
    line_data_.push_back(from_alpha);
    append(line_data_, to);
    append(line_data_, colour);
    line_data_.push_back(to_alpha);
}

void View3d::add_rays(const std::vector<PathLine>& lines) {
    const auto alpha = [](float energy) {
        return std::clamp(0.40F * std::sqrt(energy), 0.03F, 0.40F);
    };
    for (const PathLine& line : lines) {
        for (std::size_t i = 1; i < line.points.size(); ++i) {
            const float strength = alpha(line.energy[i - 1]);
            add_line(line.points[i - 1], line.points[i], order_colour(static_cast<int>(i) - 1),
                     strength, 0.75F * strength);
        }
    }
}

void View3d::add_edges(const std::vector<EdgeLine>& edges) {
    constexpr float kStrong_rad = 40 * std::numbers::pi_v<float> / 180;
    constexpr float kFree_rad = 179 * std::numbers::pi_v<float> / 180;
    const Colour colour(0.62F, 1.0F, 0.35F);
    for (const EdgeLine& edge : edges) {
        const float alpha = edge.bend_rad > kFree_rad     ? 0.9F
                            : edge.bend_rad > kStrong_rad ? 0.5F
                                                          : 0.2F;
        add_line(edge.from, edge.to, colour, alpha, alpha);
    }
}

void View3d::draw(const glm::mat4& matrix, const Vec3& eye, const RoomStyle& style, int x, int y,
                  int width, int height) {
    glViewport(x, y, width, height);
    glScissor(x, y, width, height);
    glEnable(GL_SCISSOR_TEST);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glClearColor(0.075F, 0.085F, 0.105F, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (style.solid) {
        glDisable(GL_BLEND);
        glEnable(GL_POLYGON_OFFSET_FILL);
        glPolygonOffset(1, 1);
        room_program_.use();
        glUniformMatrix4fv(room_program_.uniform("matrix"), 1, GL_FALSE, glm::value_ptr(matrix));
        glUniform3fv(room_program_.uniform("eye"), 1, glm::value_ptr(eye));
        glUniform1i(room_program_.uniform("cut_away"), style.cut_away ? 1 : 0);
        glUniform1f(room_program_.uniform("dimming"), style.first_person ? 0.35F : 0.0F);
        glUniform1f(room_program_.uniform("overlay"), has_field_ ? style.overlay_opacity : 0.0F);
        glUniform3fv(room_program_.uniform("origin"), 1, glm::value_ptr(field_origin_));
        glUniform1f(room_program_.uniform("cell"), field_cell_m_);
        const Vec3 size(field_size_);
        glUniform3fv(room_program_.uniform("size"), 1, glm::value_ptr(size));
        glUniform1i(room_program_.uniform("field"), 0);
        glUniform1i(room_program_.uniform("palette"), 1);
        glActiveTexture(GL_TEXTURE1);
        glBindTexture(GL_TEXTURE_2D, palette_texture_);
        glActiveTexture(GL_TEXTURE0);
        glBindTexture(GL_TEXTURE_3D, field_texture_);
        room_.draw(GL_TRIANGLES);
        glDisable(GL_POLYGON_OFFSET_FILL);
    }
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    line_program_.use();
    glUniformMatrix4fv(line_program_.uniform("matrix"), 1, GL_FALSE, glm::value_ptr(matrix));
    map_.draw(GL_TRIANGLES);
    glDepthMask(GL_FALSE);
    if (style.edges || !style.solid) {
        edge_program_.use();
        glUniformMatrix4fv(edge_program_.uniform("matrix"), 1, GL_FALSE, glm::value_ptr(matrix));
        glUniform3fv(edge_program_.uniform("eye"), 1, glm::value_ptr(eye));
        glUniform1i(edge_program_.uniform("cut_away"), style.cut_away ? 1 : 0);
        glUniform1f(edge_program_.uniform("strength"), style.first_person ? 0.9F
                                                       : style.solid      ? 0.55F
                                                                          : 0.7F);
        const Vec3 tint = style.solid && style.overlay_opacity < 0.5F ? Vec3(0.10F, 0.11F, 0.13F)
                                                                      : Vec3(0.62F, 0.68F, 0.76F);
        glUniform3fv(edge_program_.uniform("tint"), 1, glm::value_ptr(tint));
        edges_.draw(GL_LINES);
    }
    pick_program_.use();
    glUniformMatrix4fv(pick_program_.uniform("matrix"), 1, GL_FALSE, glm::value_ptr(matrix));
    glUniform1f(pick_program_.uniform("period"), style.stripe_pixels);
    picked_.draw(GL_TRIANGLES);
    line_program_.use();
    glUniformMatrix4fv(line_program_.uniform("matrix"), 1, GL_FALSE, glm::value_ptr(matrix));
    picked_outline_.draw(GL_LINES);
    lines_.set(line_data_, GL_STREAM_DRAW);
    lines_.draw(GL_LINES);
    line_data_.clear();
    glDepthMask(GL_TRUE);
    glDisable(GL_SCISSOR_TEST);
}

}  // namespace aula
