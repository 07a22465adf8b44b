#include "apps/window/panels.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <string>

#include "apps/documents/parameter_text.h"
#include "apps/drawing/plan_drawing.h"
#include "apps/output/formatted.h"
#include "apps/window/gl/colours.h"
#include "apps/window/rows.h"
#include "apps/window/view/direct_lines.h"

namespace aula {

bool toggle(const char* label, bool on) {
    if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_HeaderActive));
    const bool pressed = ImGui::SmallButton(label);
    if (on) ImGui::PopStyleColor();
    return pressed;
}

std::string fitting(const std::string& text, float width) {
    if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
    std::string cut = text;
    while (!cut.empty() && ImGui::CalcTextSize((cut + "...").c_str()).x > width) {
        // Removes whole UTF-8 characters.
        while (cut.size() > 1 && (static_cast<unsigned char>(cut.back()) & 0xC0U) == 0x80U)
            cut.pop_back();
        cut.pop_back();
    }
    return cut.empty() ? cut : cut + "...";
}

namespace {

/// Name, distance, visibility, T30 and C80 of the selected source: as many of them as fit.
std::string selected_source_text(const Model& model, float width) {
    const auto view = model.view();
    if (!view || view->source >= view->sources.size()) return "";
    const float distance_m = glm::distance(view->listener.position, view->sources[view->source]);
    std::string text = model.scene().sources[view->source].name;
    const auto add = [&](const std::string& more) {
        const std::string longer = text + ", " + more;
        if (ImGui::CalcTextSize(longer.c_str()).x <= width) text = longer;
    };
    add(formatted("%.1f m away", static_cast<double>(distance_m)));
    add(direct_sound_text(view->response));
    for (const AcousticParameter parameter : {AcousticParameter::t30, AcousticParameter::c80}) {
        const auto p = static_cast<std::size_t>(parameter);
        const ParameterText described = parameter_text(p);
        if (const auto& value = model.parameters().broadband[p].value)
            add(described.symbol + " " + fixed_text(*value, described.decimals) + " " +
                described.unit);
    }
    return fitting(text, width);
}

}  // namespace

void draw_top_bar(Model& model, Choices& choices, Camera& camera) {
    const PlayStatus& status = model.status();
    std::string recording = "record";
    if (const MonitorStatus& monitor = model.monitor_status(); monitor.recording) {
        recording = formatted("stop %.0f s", monitor.recorded_s);
        if (monitor.lost_s > 0) recording += formatted(", %.2f s lost", monitor.lost_s);
    }
    std::vector<const char*> labels{"first person", "freeze", recording.c_str(), "keys ?"};
    if (model.scene().listener.path) labels.push_back("follow path");
    float buttons = -ImGui::GetStyle().ItemSpacing.x;
    for (const char* label : labels)
        buttons += ImGui::CalcTextSize(label).x + 2 * ImGui::GetStyle().FramePadding.x +
                   ImGui::GetStyle().ItemSpacing.x;
    const float buttons_x = ImGui::GetWindowWidth() - buttons - ImGui::GetStyle().WindowPadding.x;
    ImGui::AlignTextToFramePadding();
    ImGui::PushFont(ImGui::GetIO().Fonts->Fonts[1]);
    const float half = 0.5F * (buttons_x - ImGui::GetCursorPosX());
    ImGui::TextUnformatted(fitting(model.scene_file().stem().string(), half).c_str());
    ImGui::PopFont();
    ImGui::SameLine(0, 16);
    const float room = buttons_x - ImGui::GetCursorPosX() - 8;
    const std::string busy = model.busy();
    if (model.changes() || !busy.empty()) {
        // Moving dots show activity.
        constexpr std::array<const char*, 4> kDots{"", " .", " ..", " ..."};
        const auto dots = static_cast<std::size_t>(3 * ImGui::GetTime()) % kDots.size();
        const std::string text =
            fitting(busy.empty() ? "preparing" : busy, room - ImGui::CalcTextSize(" ...").x);
        ImGui::TextColored({1, 0.8F, 0.3F, 1}, "%s%s", text.c_str(), kDots[dots]);
    } else if (const std::string text = selected_source_text(model, room); !text.empty()) {
        ImGui::TextUnformatted(text.c_str());
        tooltip(
            "The selected source at the listener. T30: reverberation time. C80: clarity, the "
            "energy of the first 80 ms relative to the rest. Means of the octaves of 500 and 1000 "
            "Hz.");
    }
    ImGui::SameLine(buttons_x);
    if (model.scene().listener.path) {
        if (toggle("follow path", model.follows_path())) {
            if (model.follows_path())
                model.take_listener(status.listener);
            else
                model.follow_path();
        }
        tooltip("The listener follows the scene's path (t). w a s d and the arrow keys leave it.");
        ImGui::SameLine();
    }
    if (toggle("first person", camera.first_person)) camera.first_person = !camera.first_person;
    tooltip("view from the listener's position (v)");
    ImGui::SameLine();
    if (toggle("freeze", model.frozen)) model.frozen = !model.frozen;
    tooltip("hold the plots while the sound continues (f)");
    ImGui::SameLine();
    if (toggle(recording.c_str(), model.monitor_status().recording)) model.toggle_recording();
    tooltip("record the output to a WAV file in the working directory (r)");
    ImGui::SameLine();
    if (toggle("keys ?", choices.help)) choices.help = !choices.help;
}

void draw_help(Choices& choices) {
    static constexpr std::array<std::pair<const char*, const char*>, 23> kKeys{{
        {"w s a d", "walk, step sideways (shift: run)"},
        {"arrows", "turn, look up and down"},
        {"drag", "turn the view; right button: turn the listener"},
        {"wheel", "zoom; middle button: pan"},
        {"drag a source", "move it; the listener likewise"},
        {"click a wall", "select its surface"},
        {"v", "first person on, off"},
        {"t", "follow the scene's path"},
        {"c", "collisions with walls on, off"},
        {"1 2 3", "direct, early, late sound on, off"},
        {"m", "mute, unmute all sources"},
        {"x", "switch between settings A and B"},
        {"f", "freeze the plots on, off"},
        {"p", "rays on, off"},
        {"b", "paths of the direct sound on, off"},
        {"e", "radiated energy: off, total, pulse"},
        {"g", "solid, wireframe"},
        {"ctrl z, ctrl y", "undo, redo"},
        {"r", "record the output on, off"},
        {"ctrl s", "save the edited scene"},
        {"page up, down", "previous, next scene"},
        {"ctrl + - 0", "larger, smaller, default text"},
        {"?  ctrl q", "these keys; quit"},
    }};
    ImGui::SetNextWindowPos(
        {0.5F * ImGui::GetIO().DisplaySize.x, 0.45F * ImGui::GetIO().DisplaySize.y},
        ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSizeConstraints(
        {0, 0}, {0.95F * ImGui::GetIO().DisplaySize.x, 0.9F * ImGui::GetIO().DisplaySize.y});
    if (ImGui::Begin("Keys", &choices.help,
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                         ImGuiWindowFlags_NoSavedSettings)) {
        if (ImGui::BeginTable("keys", 2)) {
            for (const auto& [key, meaning] : kKeys) {
                ImGui::TableNextRow();
                ImGui::TableNextColumn();
                ImGui::TextColored({1, 0.85F, 0.4F, 1}, "%s", key);
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(meaning);
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

void draw_messages(const Model& model, ImVec2 corner, float width, double now_s) {
    constexpr double kShown_s = 6;
    constexpr double kErrorShown_s = 20;
    constexpr double kRead_s = 1.0 / 15;  // of a character, by a slow reader
    const float wrap = std::min(width - 16, 42 * ImGui::GetFontSize());
    ImDrawList* draw = ImGui::GetForegroundDrawList();
    for (auto message = model.messages().rbegin(); message != model.messages().rend(); ++message) {
        const double shown_s = std::max(message->is_error ? kErrorShown_s : kShown_s,
                                        kRead_s * static_cast<double>(message->text.size()));
        if (now_s > message->time_s + shown_s) continue;
        const ImVec2 size = ImGui::CalcTextSize(message->text.c_str(), nullptr, false, wrap);
        corner.y -= size.y + 14;
        draw->AddRectFilled(
            {corner.x, corner.y}, {corner.x + size.x + 16, corner.y + size.y + 10},
            packed(message->is_error ? Colour(0.45F, 0.10F, 0.10F) : Colour(0.10F, 0.20F, 0.28F),
                   0.92F),
            5);
        draw->AddText(nullptr, 0, {corner.x + 8, corner.y + 5}, packed({1, 1, 1}),
                      message->text.c_str(), nullptr, wrap);
    }
}

}  // namespace aula
