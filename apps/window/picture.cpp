#include "apps/window/picture.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "apps/drawing/plan_drawing.h"
#include "apps/window/gl/colours.h"
#include "apps/window/view/lobe.h"
#include "apps/window/view/sides.h"
#include "engine/scene/scene_positions.h"

namespace aula {

namespace {

constexpr int kRays = 64;
constexpr double kPulseSlowdown = 30;
constexpr double kPulse_s = 0.25;
constexpr double kPulseWidth_s = 0.008;

glm::vec2 to_glm(const ImVec2& v) { return {v.x, v.y}; }

/// Seen from a corner, along the longer side.
float first_yaw_rad(const Bounds& bounds) {
    const Vec3 size = bounds.max - bounds.min;
    return size.x > size.y ? -2.0F : -2.6F;
}

}  // namespace

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
            shows_all_ &= camera.first_person;
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
    if (here && io.MouseDown[2] && moves && !camera.first_person) {
        camera.pan(-io.MouseDelta.x / area.height, io.MouseDelta.y / area.height);
        shows_all_ = false;
    }
    if (here && io.MouseWheel != 0 && !camera.first_person) {
        camera.zoom(std::pow(0.88F, io.MouseWheel));
        shows_all_ = false;
    }
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
        camera =
            Camera{.first_person = camera.first_person, .yaw_rad = first_yaw_rad(model.bounds())};
        std::vector<Vec3> points = scene_positions(model.scene());
        points.insert(points.end(), {model.bounds().min, model.bounds().max});
        camera.surround(points);
        shows_all_ = true;
        shown_size_ = {0, 0};
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

/// Fits the view to the picture's size until the user changes it.
void Picture::follow_size(const Model& model, const Box& area) {
    const glm::vec2 size(area.width, area.height);
    if (!shows_all_ || size == shown_size_) return;
    shown_size_ = size;
    std::vector<Vec3> points = scene_positions(model.scene());
    for (std::uint32_t t = 0; t < model.rays().triangle_count(); ++t) {
        // Sides that no sound reaches are not drawn.
        if (sides_[t] == 0) continue;
        const auto& vertices = model.rays().triangle(t).vertices;
        points.insert(points.end(), vertices.begin(), vertices.end());
    }
    camera.show(points, size.x, size.y);
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

/// Updates the cells of standing waves. True if they are shown.
bool Picture::follow_tone(const Model& model, const Choices& choices) {
    Tone tone;
    const std::size_t source = model.request.source;
    if (choices.waves.shown && model.standing_waves() && source < model.status().sources.size())
        tone = {model.standing_waves(), model.status().sources[source], choices.waves.hz};
    if (tone == tone_) return tone.waves != nullptr;
    tone_ = tone;
    cells_.reset();
    map_.reset();
    if (tone.waves) {
        const auto hz = std::min(double{tone.hz}, tone.waves->highest_hz());
        cells_.emplace(tone.waves->cells(tone.source, hz));
    }
    view_.set_map(cells_ ? &*cells_ : nullptr);
    return tone.waves != nullptr;
}

/// Updates the cells of the map that is shown.
void Picture::follow_map(const Model& model, const Choices& choices) {
    if (follow_tone(model, choices)) return;
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
            view_.add_line(line[0], line[1], kSourceColour, kAlpha, kAlpha);
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
    if (const auto& path = model.scene().listener.path) add_path(*path, kListenerColour);
    for (const Source& source : model.scene().sources)
        if (source.path) add_path(*source.path, kSourceColour);
    // In first person they would hide the walls' own edges.
    if (view && choices.direct_paths && !camera.first_person &&
        view->change == model.status().audible_change) {
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
        const SoundPath& path = view->response.paths[i];
        if (path.order == 0) continue;
        view_.add_line(here, here + std::min(1.0F, path.length_m) * path.direction,
                       order_colour(path.order), 0.95F, 0.15F);
    }
}

void Picture::draw(Model& model, const Box& area, const Choices& choices, float scale, int height,
                   double dt_s) {
    follow_scene(model);
    follow_size(model, area);
    follow_patches(model, choices, dt_s);
    follow_map(model, choices);
    add_lines(model, choices);
    const Screen projection = screen(model, area);
    if (choices.direct_paths) add_lobes(model, projection, choices);
    RoomStyle style = choices.style;
    style.overlay_opacity = overlay_opacity_;
    style.cut_away = style.cut_away && !camera.first_person;
    style.first_person = camera.first_person;
    style.stripe_pixels = scale * ImGui::GetFontSize();
    const auto pixels = [&](float x) { return static_cast<int>(std::lround(x * scale)); };
    view_.draw(projection.matrix(), projection.eye(), style, pixels(area.x),
               height - pixels(area.y + area.height), pixels(area.width), pixels(area.height));
}

}  // namespace aula
