#include "apps/window/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/documents/parameter_text.h"
#include "apps/session/base/formatted.h"
#include "apps/session/offline/measurement_text.h"
#include "apps/window/colours.h"
#include "apps/window/view/direct_lines.h"
#include "apps/window/view/lobe.h"
#include "apps/window/view/sides.h"
#include "engine/scene/scene_positions.h"

namespace aula {

namespace {

constexpr int kRays = 64;
constexpr double kPulseSlowdown = 30;
constexpr double kPulse_s = 0.25;
constexpr double kPulseWidth_s = 0.008;

const Colour kSource{1.0F, 0.60F, 0.15F};
const Colour kListener{0.35F, 0.80F, 1.0F};

glm::vec2 to_glm(const ImVec2& v) { return {v.x, v.y}; }
ImVec2 to_im(const glm::vec2& v) { return {v.x, v.y}; }

/// Intersection of a ray with a horizontal plane; empty for nearly horizontal rays.
std::optional<Vec3> on_level(const Ray& ray, float z) {
    if (std::abs(ray.direction.z) < 0.02F) return std::nullopt;
    const float distance = (z - ray.origin.z) / ray.direction.z;
    if (distance <= 0) return std::nullopt;
    return ray.origin + distance * ray.direction;
}

}  // namespace

Picture::Picture(const Model& model)
    : camera(Camera::around(model.bounds().min, model.bounds().max)) {}

Pose Picture::listener(const Model& model) const {
    return model.controls().listener.value_or(model.status().listener);
}

Screen Picture::screen(const Model& model, const Box& area) const {
    return {camera, listener(model), {area.x, area.y}, {area.width, area.height}};
}

Picture::DragTarget Picture::target_at(const Model& model, const Screen& screen,
                                       const ImVec2& mouse) const {
    const auto near = [&](const Vec3& point) {
        const auto at = screen.project(point);
        const float reach = std::max(12.0F, 0.2F * screen.pixels_per_metre(point));
        return at && glm::distance(*at, to_glm(mouse)) < std::min(reach, 40.0F);
    };
    for (std::size_t s = 0; s < model.status().sources.size(); ++s)
        if (near(model.status().sources[s])) return {DragTarget::Kind::source, s, false};
    if (!camera.first_person && near(listener(model).position))
        return {DragTarget::Kind::listener, 0, false};
    return {DragTarget::Kind::view, 0, false};
}

/// Moves the dragged source or listener horizontally, with shift vertically.
void Picture::drag(Model& model, const Screen& screen, const ImGuiIO& io) {
    const bool is_source = drag_target_.what == DragTarget::Kind::source;
    const Pose pose = listener(model);
    const Vec3 from = is_source ? model.status().sources[drag_target_.source] : pose.position;
    Vec3 to = from;
    if (io.KeyShift) {
        to.z -= io.MouseDelta.y / std::max(1.0F, screen.pixels_per_metre(from));
    } else if (const auto level = on_level(screen.ray(to_glm(io.MousePos)), from.z)) {
        to = *level;
    }
    constexpr float kMargin_m = 0.05F;
    to = glm::clamp(to, model.bounds().min + kMargin_m, model.bounds().max - kMargin_m);
    if (is_source) {
        model.move_source(drag_target_.source, to);
    } else {
        Pose moved = pose;
        moved.position = to;
        model.take_listener(moved);
    }
}

/// Picks the first visible surface under the mouse.
void Picture::pick(Model& model, const Screen& screen, const ImVec2& mouse, bool cut_away) const {
    Ray ray = screen.ray(to_glm(mouse));
    constexpr int kMaxLayers = 64;
    for (int layer = 0; layer < kMaxLayers; ++layer) {
        Hit hit;
        model.rays().intersect(std::span(&ray, 1), std::span(&hit, 1));
        if (!hit.any()) break;
        const bool front = glm::dot(model.rays().triangle(hit.triangle).normal, ray.direction) < 0;
        if (!cut_away || (sides_[hit.triangle] & (front ? 1 : 2)) != 0) {
            model.pick(hit.triangle);
            return;
        }
        ray.origin += (hit.distance_m + 1e-3F) * ray.direction;
    }
    model.deselect();
}

void Picture::interact(Model& model, const Box& area, const Choices& choices) {
    const ImGuiIO& io = ImGui::GetIO();
    const Screen projection = screen(model, area);
    const bool here = !io.WantCaptureMouse && area.contains(io.MousePos.x, io.MousePos.y);
    if (here && ImGui::IsMouseClicked(ImGuiMouseButton_Left))
        drag_target_ = target_at(model, projection, io.MousePos);
    const bool moves = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
    constexpr float kTurn_rad = 0.006F;
    if (drag_target_.what != DragTarget::Kind::nothing && io.MouseDown[0]) {
        drag_target_.moved |= ImGui::IsMouseDragging(ImGuiMouseButton_Left, 4);
        if (drag_target_.moved && moves && drag_target_.what != DragTarget::Kind::view)
            drag(model, projection, io);
        if (drag_target_.moved && moves && drag_target_.what == DragTarget::Kind::view) {
            if (io.KeyShift && !camera.first_person)
                camera.pan(-io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
            else if (!camera.first_person)
                camera.turn(-kTurn_rad * io.MouseDelta.x, kTurn_rad * io.MouseDelta.y);
        }
    }
    const bool turns_listener =
        (here && io.MouseDown[1]) ||
        (camera.first_person && drag_target_.what == DragTarget::Kind::view && drag_target_.moved);
    if (turns_listener && moves) {
        Pose pose = listener(model);
        pose.yaw_rad -= 0.6F * kTurn_rad * io.MouseDelta.x;
        pose.pitch_rad =
            std::clamp(pose.pitch_rad - 0.6F * kTurn_rad * io.MouseDelta.y, -1.4F, 1.4F);
        model.take_listener(pose);
    }
    if (here && io.MouseDown[2] && !camera.first_person)
        camera.pan(-io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
    if (here && io.MouseWheel != 0 && !camera.first_person)
        camera.zoom(std::pow(0.88F, io.MouseWheel));
    if (!io.MouseDown[0] && drag_target_.what != DragTarget::Kind::nothing) {
        if (drag_target_.what == DragTarget::Kind::source && drag_target_.moved)
            model.source_moved();
        if (drag_target_.what == DragTarget::Kind::view && !drag_target_.moved && here)
            pick(model, projection, io.MousePos, choices.style.cut_away && !camera.first_person);
        drag_target_ = {};
    }
}

/// Updates the triangles after a change of the scene or a movement.
void Picture::follow_scene(Model& model) {
    if (geometry_version_ != model.geometry_version()) {
        sides_ = interior_sides(model.rays(), scene_positions(model.scene()));
        if (geometry_version_ != 0) {
            const bool first_person = camera.first_person;
            camera = Camera::around(model.bounds().min, model.bounds().max);
            camera.first_person = first_person;
        }
        geometry_version_ = model.geometry_version();
        field_patch_m_ = 0;
    }
    if (scene_version_ != model.scene_version()) {
        view_.set_room(model.scene(), model.rays(), sides_);
        scene_version_ = model.scene_version();
        picked_ = kNoTriangle;
    } else if (std::any_of(model.scene().objects.begin(), model.scene().objects.end(),
                           [](const Object& object) { return object.path.has_value(); })) {
        view_.move_room(model.rays());
    }
    const std::uint32_t picked = model.surface() ? model.surface()->picked : kNoTriangle;
    if (picked != picked_) {
        picked_ = picked;
        view_.set_picked(model.rays(), model.surface() ? model.surface()->triangles
                                                       : std::vector<std::uint32_t>{});
    }
}

void Picture::follow_patches(Model& model, const Choices& choices, double dt_s) {
    ViewRequest request = model.request;
    request.lines = choices.rays ? kRays : 0;
    request.edges = choices.direct_paths;
    request.patches = choices.overlay != EnergyOverlay::off;
    request.patches_begin_s = 0;
    request.patches_end_s = 10;
    if (choices.overlay == EnergyOverlay::pulse) {
        pulse_s_ = std::fmod(pulse_s_ + dt_s / kPulseSlowdown, kPulse_s);
        request.patches_begin_s = std::max(0.0, pulse_s_ - kPulseWidth_s);
        request.patches_end_s = pulse_s_;
    }
    model.request = request;
    model.watch();
    overlay_opacity_ +=
        (choices.overlay == EnergyOverlay::off ? -1.0F : 1.0F) * static_cast<float>(3 * dt_s);
    overlay_opacity_ = std::clamp(overlay_opacity_, 0.0F, 1.0F);
    const auto view = model.view();
    if (!view || !request.patches || view->patch_size_m <= 0) return;
    if (view->patch_size_m != field_patch_m_) {
        field_patch_m_ = view->patch_size_m;
        field_.cover(model.bounds().min, model.bounds().max, field_patch_m_);
    }
    if (view->patches.empty() && choices.overlay == EnergyOverlay::total) return;
    field_.update(view->patches, choices.plots.band, dt_s);
    view_.set_patches(field_);
}

/// Updates the cells of the map that is shown.
void Picture::follow_map(const Model& model, const Choices& choices) {
    const auto map = choices.map.shown ? model.map() : nullptr;
    MapChoice choice = choices.map.choice;
    choice.source = model.request.source;
    if (map == map_ && (!map || choice == map_choice_)) return;
    map_ = map;
    map_choice_ = choice;
    if (map)
        cells_.emplace(map->grid, map->measurement, model.bounds(), choice);
    else
        cells_.reset();
    view_.set_map(cells_ ? &*cells_ : nullptr);
}

/// Draws the scale of the map's colours upwards from a corner, with the value at the mouse.
void Picture::draw_map_scale(const Model& model, const Screen& projection, ImVec2 corner,
                             ImDrawList& draw) const {
    const float em = ImGui::GetFontSize();
    const float width = 16 * em;
    constexpr int kSteps = 64;
    const ParameterText text = parameter_text(map_choice_.parameter);
    const bool octave = map_choice_.band && map_choice_.parameter != kSpeechTransmission;
    std::string title = text.symbol + (text.unit.empty() ? "" : " in " + text.unit) + ", " +
                        (octave ? band_name(*map_choice_.band) + " Hz" : text.single) + ", " +
                        model.scene().sources[map_choice_.source].name;
    if (!model.map_is_current()) title += " (before the last change)";
    const ImGuiIO& io = ImGui::GetIO();
    if (const auto point = on_level(projection.ray(to_glm(io.MousePos)), cells_->height_m());
        point && !io.WantCaptureMouse) {
        const MapCells::Cell* const cell = cells_->at(glm::vec2(*point));
        if (cell != nullptr)
            title += cell->value ? ": " + fixed_text(*cell->value, text.decimals) + " " + text.unit
                                 : ": no value";
    }
    const ImVec2 top{corner.x, corner.y - 2.2F * em};
    draw.AddRectFilled({top.x - 6, top.y - 0.2F * em},
                       {top.x + std::max(width + 3 * em, ImGui::CalcTextSize(title.c_str()).x) + 6,
                        corner.y + 1.4F * em},
                       packed({0.05F, 0.06F, 0.08F}, 0.8F), 3);
    const ImU32 ink = packed({0.85F, 0.88F, 0.93F});
    draw.AddText(top, ink, title.c_str());
    // Numbers are centred at their marks, and may begin left of the bar.
    const float left = top.x + 1.5F * em;
    const float y = corner.y - 0.8F * em;
    for (int i = 0; i < kSteps; ++i)
        draw.AddRectFilled({left + width * static_cast<float>(i) / kSteps, y},
                           {left + width * static_cast<float>(i + 1) / kSteps, y + 0.7F * em},
                           packed(map_colour((static_cast<float>(i) + 0.5F) / kSteps)));
    const ValueScale& scale = cells_->scale();
    const std::vector<double> marks = round_numbers(scale.min, scale.max, 4);
    for (const double mark : marks) {
        const float x =
            left + width * static_cast<float>((mark - scale.min) / (scale.max - scale.min));
        const std::string number = fixed_text(mark, decimals_of(marks));
        draw.AddLine({x, y + 0.7F * em}, {x, y + 0.95F * em}, ink);
        draw.AddText({x - ImGui::CalcTextSize(number.c_str()).x / 2, y + em}, ink, number.c_str());
    }
}

/// Adds the lobes of the directive sources, of at least a metre and 60 pixels.
void Picture::add_lobes(const Model& model, const Screen& projection, const Choices& choices) {
    constexpr float kRadius_m = 1;
    constexpr float kLeastPixels = 60;
    constexpr float kAlpha = 0.6F;
    const auto view = model.view();
    if (!view) return;
    const auto& sources = model.scene().sources;
    for (std::size_t s = 0; s < std::min(sources.size(), view->source_rotations.size()); ++s) {
        if (sources[s].directivity.is_omnidirectional()) continue;
        const Vec3& at = view->sources[s];
        const float radius_m =
            std::max(kRadius_m, kLeastPixels / std::max(1.0F, projection.pixels_per_metre(at)));
        for (const auto& line : lobe_lines(sources[s].directivity, choices.plots.band, at,
                                           view->source_rotations[s], radius_m))
            view_.add_line(line[0], line[1], kSource, kAlpha, kAlpha);
    }
}

void Picture::add_lines(const Model& model, const Choices& choices) {
    const auto view = model.view();
    const auto add_path = [&](const Trajectory& path, const Colour& colour) {
        constexpr int kSteps = 100;
        Vec3 from = path.at(0).position;
        for (int i = 1; i <= kSteps; ++i) {
            const Vec3 to = path.at(path.duration_s() * i / kSteps).position;
            if (i % 2 == 0) view_.add_line(from, to, colour, 0.8F, 0.8F);
            from = to;
        }
    };
    if (const auto& path = model.scene().listener.path) add_path(*path, kListener);
    for (const Source& source : model.scene().sources)
        if (source.path) add_path(*source.path, kSource);
    if (view && choices.direct_paths && view->change == model.status().audible_change) {
        // Edges that no sound reaches, as those on the outside of a room, are omitted.
        std::vector<EdgeLine> edges = view->edges;
        std::erase_if(edges, [&](const EdgeLine& edge) {
            if (edge.triangle >= sides_.size()) return true;
            const Vec3& normal = model.rays().triangle(edge.triangle).normal;
            return (sides_[edge.triangle] & (glm::dot(normal, edge.facing) > 0 ? 1 : 2)) == 0;
        });
        view_.add_edges(edges);
    }
    if (!view || !choices.rays) return;
    view_.add_rays(view->lines);
    // Directions of arrival of the image sources.
    if (camera.first_person) return;
    constexpr std::size_t kMax = 40;
    const Vec3 here = view->listener.position;
    for (std::size_t i = 0; i < std::min(kMax, view->response.paths.size()); ++i) {
        const SpecularPath& path = view->response.paths[i];
        if (path.order == 0) continue;
        view_.add_line(here, here + std::min(1.0F, path.length_m) * path.direction,
                       order_colour(path.order), 0.95F, 0.15F);
    }
}

/// Draws the paths of the direct sound, above the room.
void Picture::draw_direct_paths(const Model& model, const Screen& projection,
                                ImDrawList& draw) const {
    constexpr float kDash_m = 0.15F;
    constexpr float kPrimaryWidth = 2.5F;
    constexpr float kWidth = 1.5F;
    const auto view = model.view();
    if (!view || camera.first_person || view->source >= view->sources.size()) return;
    const auto segment = [&](const Vec3& from, const Vec3& to, ImU32 colour, float width) {
        const auto a = projection.project(from);
        const auto b = projection.project(to);
        if (a && b) draw.AddLine(to_im(*a), to_im(*b), colour, width);
    };
    for (const DirectLine& line :
         direct_lines(view->response, view->sources[view->source], view->listener.position)) {
        const ImU32 colour = packed(order_colour(0), line.opacity);
        const float width = line.is_primary ? kPrimaryWidth : kWidth;
        for (std::size_t i = 1; i < line.points.size(); ++i) {
            const Vec3& from = line.points[i - 1];
            const Vec3& to = line.points[i];
            if (!line.through_walls)
                segment(from, to, colour, width);
            else
                for (const auto& dash : dashes(from, to, kDash_m))
                    segment(dash[0], dash[1], colour, width);
        }
    }
}

void Picture::draw(Model& model, const Box& area, const Choices& choices, float scale, int height,
                   double dt_s) {
    follow_scene(model);
    follow_patches(model, choices, dt_s);
    follow_map(model, choices);
    add_lines(model, choices);
    const Screen projection = screen(model, area);
    if (choices.direct_paths) add_lobes(model, projection, choices);
    RoomStyle style = choices.style;
    style.overlay_opacity = overlay_opacity_;
    style.cut_away = style.cut_away && !camera.first_person;
    const auto pixels = [&](float x) { return static_cast<int>(std::lround(x * scale)); };
    view_.draw(projection.matrix(), projection.eye(), style, pixels(area.x),
               height - pixels(area.y + area.height), pixels(area.width), pixels(area.height));
}

void Picture::draw_labels(const Model& model, const Box& area, const Choices& choices) const {
    ImDrawList* draw = ImGui::GetBackgroundDrawList();
    draw->PushClipRect({area.x, area.y}, {area.x + area.width, area.y + area.height});
    const Screen projection = screen(model, area);
    const float em = ImGui::GetFontSize();
    if (choices.direct_paths) draw_direct_paths(model, projection, *draw);
    const auto label = [&](const glm::vec2& at, const std::string& text, const Colour& colour) {
        const ImVec2 size = ImGui::CalcTextSize(text.c_str());
        const ImVec2 corner{at.x - size.x / 2, at.y - 2.0F * em};
        draw->AddRectFilled({corner.x - 4, corner.y - 2},
                            {corner.x + size.x + 4, corner.y + size.y + 2},
                            packed({0.05F, 0.06F, 0.08F}, 0.75F), 3);
        draw->AddText(corner, packed(colour), text.c_str());
    };
    for (std::size_t s = 0; s < model.status().sources.size(); ++s) {
        if (s >= model.scene().sources.size()) break;
        const Vec3 position = model.status().sources[s];
        const auto at = projection.project(position);
        if (!at) continue;
        const float radius = std::clamp(0.12F * projection.pixels_per_metre(position), 6.0F, 26.0F);
        const bool audible = model.controls().audible(s);
        draw->AddCircleFilled(to_im(*at), radius, packed(audible ? kSource : Colour(0.45F), 0.95F),
                              24);
        draw->AddCircle(to_im(*at), radius, packed({0.1F, 0.05F, 0}, 0.9F), 24, 1.5F);
        for (int ring = 1; audible && ring <= 2; ++ring)
            draw->AddCircle(to_im(*at), radius * (1 + 0.45F * static_cast<float>(ring)),
                            packed(kSource, 0.6F / static_cast<float>(ring)), 24, 1.5F);
        label(*at - glm::vec2(0, radius), model.scene().sources[s].name, kSource);
    }
    const Pose pose = listener(model);
    if (!camera.first_person) {
        if (const auto at = projection.project(pose.position)) {
            const glm::mat3 axes = pose.rotation();
            const float size_m =
                std::max(0.16F, 9 / std::max(1.0F, projection.pixels_per_metre(pose.position)));
            const auto nose = projection.project(pose.position + 2.4F * size_m * axes[0]);
            const auto left = projection.project(pose.position + size_m * axes[1]);
            const auto right = projection.project(pose.position - size_m * axes[1]);
            if (nose && left && right)
                draw->AddTriangleFilled(to_im(*nose), to_im(*left), to_im(*right),
                                        packed(kListener, 0.85F));
            draw->AddCircleFilled(
                to_im(*at),
                std::clamp(size_m * projection.pixels_per_metre(pose.position), 6.0F, 30.0F),
                packed(kListener), 24);
            label(*at - glm::vec2(0, 0.5F * em), "listener", kListener);
        }
    }
    ImVec2 corner{area.x + 12, area.y + area.height - 2.0F * em};
    if (choices.rays) {
        const auto word = [&](const char* text, const Colour& colour) {
            draw->AddText({corner.x + 1, corner.y + 1}, packed({0, 0, 0}, 0.8F), text);
            draw->AddText(corner, packed(colour), text);
            corner.x += ImGui::CalcTextSize(text).x + 0.6F * em;
        };
        word("reflection order", {0.8F, 0.84F, 0.9F});
        for (const auto& [order, text] :
             {std::pair{0, "0"}, {1, "1"}, {2, "2"}, {3, "3"}, {4, "4"}})
            word(text, order_colour(order));
        corner = {area.x + 12, corner.y - 1.6F * em};
    }
    if (choices.overlay != EnergyOverlay::off) {
        const float width = 12 * em;
        constexpr int kSteps = 24;
        for (int i = 0; i < kSteps; ++i)
            draw->AddRectFilled(
                {corner.x + width * static_cast<float>(i) / kSteps, corner.y + 0.2F * em},
                {corner.x + width * static_cast<float>(i + 1) / kSteps, corner.y + 0.9F * em},
                packed(map_colour(static_cast<float>(i) / (kSteps - 1))));
        std::array<char, 64> text{};
        if (choices.overlay == EnergyOverlay::pulse)
            std::snprintf(text.data(), text.size(), "range 30 dB, %.0f ms after emission",
                          1000 * pulse_s_);
        else
            std::snprintf(text.data(), text.size(), "radiated energy, range 30 dB");
        draw->AddText({corner.x + width + 8, corner.y}, packed({0.85F, 0.88F, 0.93F}), text.data());
        const auto view = model.view();
        if (view && view->patch_size_m <= 0)
            draw->AddText({corner.x, corner.y - 1.3F * em}, packed({1, 0.8F, 0.4F}),
                          "this estimator has no patches");
        corner.y -= 3 * em;
    }
    if (cells_ && map_choice_.source < model.scene().sources.size())
        draw_map_scale(model, projection, {corner.x, corner.y - 0.4F * em}, *draw);
    draw->PopClipRect();
}

}  // namespace aula
