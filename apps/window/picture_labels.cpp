#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "apps/documents/parameter_text.h"
#include "apps/drawing/plan_drawing.h"
#include "apps/output/formatted.h"
#include "apps/room/offline/measurement_text.h"
#include "apps/window/gl/colours.h"
#include "apps/window/picture.h"
#include "apps/window/view/direct_lines.h"

// What Dear ImGui draws over the picture: names, symbols, paths, legends.

namespace aula {

namespace {

ImVec2 to_im(const glm::vec2& v) { return {v.x, v.y}; }

/// Draws a text above a point, inside the picture.
void draw_name(ImDrawList& draw, const glm::vec2& at, const std::string& text,
               const Colour& colour) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    constexpr float kMargin = 6;
    const ImVec2 low = draw.GetClipRectMin();
    const ImVec2 high = draw.GetClipRectMax();
    const ImVec2 corner{
        std::max(low.x + kMargin, std::min(at.x - size.x / 2, high.x - size.x - kMargin)),
        std::max(low.y + kMargin, at.y - 2 * ImGui::GetFontSize())};
    draw.AddRectFilled({corner.x - 4, corner.y - 2}, {corner.x + size.x + 4, corner.y + size.y + 2},
                       packed({0.05F, 0.06F, 0.08F}, 0.75F), 3);
    draw.AddText(corner, packed(colour), text.c_str());
}

}  // namespace

std::string Picture::map_title(const Model& model, const ParameterText& text) const {
    const bool octave = map_choice_.band && map_choice_.parameter != kSpeechTransmission;
    std::string title = text.symbol + (text.unit.empty() ? "" : " in " + text.unit) + ", " +
                        (octave ? band_name(*map_choice_.band) + " Hz" : text.single) + ", " +
                        model.scene().sources[map_choice_.source].name;
    if (!model.map_is_current()) title += " (before the last change)";
    return title;
}

std::string Picture::wave_title(const Model& model) const {
    return "level in dB re 10 m in free field, " + fixed_text(double{tone_.hz}, 1) + " Hz, " +
           model.scene().sources[model.request.source].name;
}

/// Draws the scale of the map's colours upwards from a corner, with the value at the mouse.
void Picture::draw_map_scale(const Model& model, const Screen& projection, ImVec2 corner,
                             ImDrawList& draw) const {
    const float em = ImGui::GetFontSize();
    const float width = 16 * em;
    constexpr int kSteps = 64;
    const ParameterText text = parameter_text(
        tone_.waves ? static_cast<std::size_t>(AcousticParameter::g) : map_choice_.parameter);
    std::string title = tone_.waves ? wave_title(model) : map_title(model, text);
    const ImGuiIO& io = ImGui::GetIO();
    if (const auto point =
            on_level(projection.ray({io.MousePos.x, io.MousePos.y}), cells_->height_m());
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

/// Whether a wall hides a point from the listener, in first person.
bool Picture::is_hidden(const Model& model, const Vec3& point) const {
    constexpr float kNear_m = 0.1F;  // a source may lie on a surface
    if (!camera.first_person) return false;
    const Vec3 eye = camera.eye(listener(model));
    const float distance_m = glm::distance(eye, point);
    if (distance_m <= kNear_m) return false;
    const Ray ray{eye, (point - eye) / distance_m, distance_m - kNear_m};
    Hit hit;
    model.rays().intersect(std::span(&ray, 1), std::span(&hit, 1));
    return hit.any();
}

void Picture::draw_sources(const Model& model, const Screen& projection, ImDrawList& draw) const {
    for (std::size_t s = 0; s < model.status().sources.size(); ++s) {
        if (s >= model.scene().sources.size()) break;
        const Vec3 position = model.status().sources[s];
        const auto at = projection.project(position);
        if (!at) continue;
        const float radius = std::clamp(0.12F * projection.pixels_per_metre(position), 6.0F, 26.0F);
        const bool audible = model.controls().audible(s);
        const Colour colour = audible ? kSourceColour : Colour(0.45F);
        if (is_hidden(model, position)) {
            draw.AddCircle(to_im(*at), radius, packed(colour, 0.8F), 4, 2);  // a rhombus
            draw_name(draw, *at - glm::vec2(0, radius), model.scene().sources[s].name + ", hidden",
                      colour);
            continue;
        }
        draw.AddCircleFilled(to_im(*at), radius, packed(colour, 0.95F), 24);
        draw.AddCircle(to_im(*at), radius, packed({0.1F, 0.05F, 0}, 0.9F), 24, 1.5F);
        for (int ring = 1; audible && ring <= 2; ++ring)
            draw.AddCircle(to_im(*at), radius * (1 + 0.45F * static_cast<float>(ring)),
                           packed(kSourceColour, 0.6F / static_cast<float>(ring)), 24, 1.5F);
        draw_name(draw, *at - glm::vec2(0, radius), model.scene().sources[s].name, kSourceColour);
    }
}

void Picture::draw_listener(const Model& model, const Screen& projection, ImDrawList& draw) const {
    const Pose pose = listener(model);
    if (const auto at = projection.project(pose.position)) {
        const glm::mat3 axes = pose.rotation();
        const float size_m =
            std::max(0.16F, 9 / std::max(1.0F, projection.pixels_per_metre(pose.position)));
        const auto nose = projection.project(pose.position + 2.4F * size_m * axes[0]);
        const auto left = projection.project(pose.position + size_m * axes[1]);
        const auto right = projection.project(pose.position - size_m * axes[1]);
        if (nose && left && right)
            draw.AddTriangleFilled(to_im(*nose), to_im(*left), to_im(*right),
                                   packed(kListenerColour, 0.85F));
        draw.AddCircleFilled(
            to_im(*at),
            std::clamp(size_m * projection.pixels_per_metre(pose.position), 6.0F, 30.0F),
            packed(kListenerColour), 24);
        draw_name(draw, *at - glm::vec2(0, 0.5F * ImGui::GetFontSize()), "listener",
                  kListenerColour);
    }
}

/// Draws what the colours mean, upwards from the lower left corner.
void Picture::draw_legends(const Model& model, const Screen& projection, const Box& area,
                           const Choices& choices, ImDrawList& draw) const {
    const float em = ImGui::GetFontSize();
    ImVec2 corner{area.x + 12, area.y + area.height - 2.0F * em};
    if (choices.rays) {
        const std::array<std::pair<const char*, Colour>, 6> words{{
            {"reflection order", {0.8F, 0.84F, 0.9F}},
            {"0", order_colour(0)},
            {"1", order_colour(1)},
            {"2", order_colour(2)},
            {"3", order_colour(3)},
            {"4", order_colour(4)},
        }};
        const float gap = 0.6F * em;
        float width = 0;
        for (const auto& [word, colour] : words) width += ImGui::CalcTextSize(word).x + gap;
        draw.AddRectFilled({corner.x - 6, corner.y - 3}, {corner.x + width, corner.y + 1.3F * em},
                           packed({0.05F, 0.06F, 0.08F}, 0.75F), 3);
        for (const auto& [word, colour] : words) {
            draw.AddText(corner, packed(colour), word);
            corner.x += ImGui::CalcTextSize(word).x + gap;
        }
        corner = {area.x + 12, corner.y - 1.6F * em};
    }
    if (choices.overlay != EnergyOverlay::off) {
        const float width = 12 * em;
        constexpr int kSteps = 24;
        for (int i = 0; i < kSteps; ++i)
            draw.AddRectFilled(
                {corner.x + width * static_cast<float>(i) / kSteps, corner.y + 0.2F * em},
                {corner.x + width * static_cast<float>(i + 1) / kSteps, corner.y + 0.9F * em},
                packed(map_colour(static_cast<float>(i) / (kSteps - 1))));
        std::array<char, 64> text{};
        if (choices.overlay == EnergyOverlay::pulse)
            std::snprintf(text.data(), text.size(), "range 30 dB, %.0f ms after emission",
                          1000 * pulse_s_);
        else
            std::snprintf(text.data(), text.size(), "radiated energy, range 30 dB");
        draw.AddText({corner.x + width + 8, corner.y}, packed({0.85F, 0.88F, 0.93F}), text.data());
        const auto view = model.view();
        if (view && view->patch_size_m <= 0)
            draw.AddText({corner.x, corner.y - 1.3F * em}, packed({1, 0.8F, 0.4F}),
                         "this method has no patches");
        corner.y -= 3 * em;
    }
    if (cells_ && (tone_.waves || map_choice_.source < model.scene().sources.size()))
        draw_map_scale(model, projection, {corner.x, corner.y - 0.4F * em}, draw);
}

void Picture::draw_labels(const Model& model, const Box& area, const Choices& choices) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    draw.PushClipRect({area.x, area.y}, {area.x + area.width, area.y + area.height});
    const Screen projection = screen(model, area);
    if (choices.direct_paths) draw_direct_paths(model, projection, draw);
    const float em = ImGui::GetFontSize();
    if (camera.first_person)
        plan_.draw(model, listener(model), {area.x + area.width - 0.6F * em, area.y + 0.6F * em},
                   std::min(11 * em, 0.32F * area.height), draw);
    else
        draw_listener(model, projection, draw);
    draw_sources(model, projection, draw);
    draw_legends(model, projection, area, choices, draw);
    draw.PopClipRect();
}

}  // namespace aula
