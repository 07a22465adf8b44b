#include "apps/window/rows.h"

#include <imgui_internal.h>

#include <algorithm>

#include "apps/drawing/plan_drawing.h"
#include "apps/window/plots.h"

namespace aula {

namespace {

// Widths of the columns in text heights: of "early bounces" and "351 of 33 ms".
constexpr float kName_em = 7.2F;
constexpr float kValue_em = 6.3F;

/// Draws the name at the left. Returns where the middle column begins.
float begin_row(const char* name, const char* meaning) {
    const float left = ImGui::GetCursorPosX();
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(name);
    tooltip(meaning);
    return left + kName_em * ImGui::GetFontSize();
}

/// Draws a value at the right end of the row. Returns the width of its column.
float draw_value(const std::string& value) {
    if (value.empty()) return 0;
    const float right = ImGui::GetWindowContentRegionMax().x;
    ImGui::SameLine(right - ImGui::CalcTextSize(value.c_str()).x);
    ImGui::TextUnformatted(value.c_str());
    return kValue_em * ImGui::GetFontSize();
}

/// Calls a slider, with its number only while the number is edited.
template <typename Slider>
bool without_number(const char* label, const Slider& slider) {
    const bool edited = ImGui::TempInputIsActive(ImGui::GetID(label));
    if (!edited) ImGui::PushStyleColor(ImGuiCol_Text, 0);
    const bool changed = slider();
    if (!edited) ImGui::PopStyleColor();
    return changed;
}

}  // namespace

bool row(const char* name, const char* meaning, const std::string& value,
         const std::function<bool(const char* label)>& control) {
    const float middle = begin_row(name, meaning);
    const float value_width = draw_value(value);
    ImGui::SameLine(middle);
    ImGui::SetNextItemWidth(ImGui::GetWindowContentRegionMax().x - value_width - middle);
    const bool changed = control((std::string("##") + name).c_str());
    tooltip(meaning);
    return changed;
}

bool bare_slider(const char* label, float* value, float from, float to, const char* format,
                 ImGuiSliderFlags flags) {
    return without_number(
        label, [&] { return ImGui::SliderFloat(label, value, from, to, format, flags); });
}

bool bare_slider(const char* label, int* value, int from, int to, ImGuiSliderFlags flags) {
    return without_number(label,
                          [&] { return ImGui::SliderInt(label, value, from, to, "%d", flags); });
}

void text_row(const char* name, const char* meaning, const std::string& text) {
    const float middle = begin_row(name, meaning);
    ImGui::SameLine(middle);
    ImGui::TextUnformatted(text.c_str());
    tooltip(meaning);
}

void bar_row(const char* name, const char* meaning, const std::string& value,
             std::initializer_list<BarPart> parts, double mark) {
    row(name, meaning, value, [&](const char*) {
        const ImVec2 corner = ImGui::GetCursorScreenPos();
        const ImVec2 size{ImGui::CalcItemWidth(), ImGui::GetFrameHeight()};
        ImGui::Dummy(size);
        // Lower than a slider: it cannot be moved.
        const float top = corner.y + 0.25F * size.y;
        const float bottom = corner.y + 0.75F * size.y;
        const auto x = [&](double share) {
            return corner.x + static_cast<float>(std::clamp(share, 0.0, 1.0)) * size.x;
        };
        ImDrawList* draw = ImGui::GetWindowDrawList();
        draw->AddRectFilled({x(0), top}, {x(1), bottom}, packed({0.06F, 0.07F, 0.085F}), 3);
        double from = 0;
        for (const BarPart& part : parts) {
            const double to = std::min(1.0, from + std::max(0.0, part.share));
            draw->AddRectFilled({x(from), top}, {x(to), bottom}, packed(part.colour, 0.85F), 2);
            from = to;
        }
        if (mark >= 0)
            draw->AddLine({x(mark), top - 2}, {x(mark), bottom + 2}, packed({1, 1, 1}, 0.9F), 2);
        return false;
    });
}

void same_line_for(const char* label) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float width = ImGui::CalcTextSize(label).x + 2 * style.FramePadding.x;
    const float left = ImGui::GetItemRectMax().x + style.ItemSpacing.x - ImGui::GetWindowPos().x;
    if (left + width <= ImGui::GetWindowContentRegionMax().x) ImGui::SameLine();
}

void tooltip(const char* text) {
    if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
    constexpr float kGap = 6;
    const ImVec2 display = ImGui::GetIO().DisplaySize;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const ImGuiWindow* const bar = ImGui::FindWindowByName("bar");
    const ImGuiWindow* const plots = ImGui::FindWindowByName("plots");
    const float top = bar != nullptr ? bar->Pos.y + bar->Size.y + kGap : 0;
    const float bottom = plots != nullptr ? plots->Pos.y - kGap : display.y;
    const ImGuiWindow* const controls = ImGui::FindWindowByName("controls");
    const float right = controls != nullptr ? controls->Pos.x - kGap : display.x;
    const float across = std::min(1.0F, mouse.x / right);
    // The picture lies left of the panels at the side, below the bar and above the plots.
    const float left = ImGui::GetWindowPos().x;
    const float down = mouse.y / display.y;
    if (left > 0)
        ImGui::SetNextWindowPos({left - kGap, top + down * (bottom - top)}, ImGuiCond_Always,
                                {1, down});
    else
        ImGui::SetNextWindowPos({across * right, mouse.y < top ? top : bottom}, ImGuiCond_Always,
                                {across, mouse.y < top ? 0.0F : 1.0F});
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(24 * ImGui::GetFontSize());
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

}  // namespace aula
