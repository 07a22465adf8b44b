#include "apps/window/panels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <numbers>

#include "apps/window/colours.h"

namespace aula {

namespace {

template <typename... Values>
std::string formatted(const char* format, Values... values) {
    std::array<char, 160> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

bool toggle(const char* label, bool on) {
    if (on) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_HeaderActive));
    const bool pressed = ImGui::SmallButton(label);
    if (on) ImGui::PopStyleColor();
    return pressed;
}

bool section(const char* name, bool open = true) {
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

void draw_source(Model& model, std::size_t s) {
    const Source& source = model.scene().sources[s];
    SourceControl& control = model.controls.sources[s];
    ImGui::PushID(static_cast<int>(s));
    bool changed = false;
    const bool watched = model.request.source == s;
    if (ImGui::Selectable(source.name.c_str(), watched && model.scene().sources.size() > 1, 0,
                          {ImGui::GetContentRegionAvail().x - 4.2F * ImGui::GetFontSize(), 0})) {
        model.request.source = s;
        model.watch();
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("rays, patches and plots show this source");
    ImGui::SameLine();
    if (toggle("M", control.muted)) {
        control.muted = !control.muted;
        changed = true;
    }
    ImGui::SameLine(0, 4);
    if (toggle("S", control.solo)) {
        control.solo = !control.solo;
        changed = true;
    }
    float gain_db = control.gain_db.value_or(source.gain_db);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    if (ImGui::SliderFloat("##gain", &gain_db, -40, 20, "%.1f dB")) {
        control.gain_db = gain_db;
        changed = true;
    }
    ImGui::SameLine(0, 4);
    const std::string& chosen = model.other_signal(s);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    if (ImGui::BeginCombo("##signal", chosen.empty() ? "its own signal" : chosen.c_str())) {
        if (ImGui::Selectable("its own signal", chosen.empty())) model.play_own_signal(s);
        for (const TestSignal signal :
             {TestSignal::clap, TestSignal::noise_burst, TestSignal::noise, TestSignal::clicks}) {
            if (ImGui::Selectable(test_signal_name(signal), chosen == test_signal_name(signal)))
                model.play_test_signal(s, signal);
        }
        if (ImGui::Selectable("microphone", chosen == "microphone")) model.play_microphone(s);
        ImGui::EndCombo();
    }
    if (changed) model.hand_over();
    ImGui::PopID();
}

void draw_parts(Model& model) {
    PlayControls& controls = model.controls;
    bool changed = ImGui::Checkbox("direct", &controls.direct);
    ImGui::SameLine();
    changed |= ImGui::Checkbox("early", &controls.early);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("image sources");
    ImGui::SameLine();
    changed |= ImGui::Checkbox("late", &controls.late);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("reverberation, from the caches");
    ImGui::SetNextItemWidth(-1);
    changed |= ImGui::SliderFloat("##wet", &controls.wet, 0, 1,
                                  controls.wet == 0.5F  ? "dry - as it is - wet"
                                  : controls.wet < 0.5F ? "drier"
                                                        : "wetter");
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
        controls.wet = 0.5F;
        changed = true;
    }
    if (changed) model.hand_over();
}

struct Preset {
    const char* name;
    const char* meaning;
    void (*set)(Simulation&);
};

constexpr std::array<Preset, 4> kPresets{{
    {"draft", "for slow machines: few rays, first-order image sources",
     [](Simulation& s) {
         s.estimator = Estimator::patch;
         s.rays = 300;
         s.specular_order = 1;
         s.patch_size_m = 1;
         s.response_time_s = 0.5F;
     }},
    {"normal", "what a scene has if it says nothing",
     [](Simulation& s) {
         const Simulation usual;
         s.estimator = usual.estimator;
         s.rays = usual.rays;
         s.order = usual.order;
         s.specular_order = usual.specular_order;
         s.patch_size_m = usual.patch_size_m;
         s.response_time_s = usual.response_time_s;
     }},
    {"fine", "small patches, many rays",
     [](Simulation& s) {
         s.estimator = Estimator::patch;
         s.rays = 3000;
         s.specular_order = 4;
         s.patch_size_m = 0.35F;
         s.response_time_s = 1;
     }},
    {"plain", "path tracing without a cache, to compare with",
     [](Simulation& s) {
         s.estimator = Estimator::pt;
         s.rays = 1000;
     }},
}};

void draw_settings(Model& model, Choices& choices) {
    for (const std::size_t slot : {0U, 1U}) {
        if (slot == 1) ImGui::SameLine(0, 4);
        if (toggle(slot == 0 ? " A " : " B ", model.active() == slot) && model.active() != slot)
            model.switch_setting();
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("two settings to compare; x goes to the other");
    for (const Preset& preset : kPresets) {
        ImGui::SameLine(0, 4);
        if (ImGui::SmallButton(preset.name)) {
            Simulation s = model.setting().simulation;
            preset.set(s);
            model.controls.rays.reset();
            model.hand_over();
            model.set_simulation(s, model.setting().ambisonic_order);
        }
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", preset.meaning);
    }

    // What is being dragged is taken over when it is let go: it takes a moment to prepare.
    Simulation s = choices.draft.value_or(model.setting().simulation);
    bool done = false;
    bool active = false;
    const auto item = [&] {
        done |= ImGui::IsItemDeactivatedAfterEdit();
        active |= ImGui::IsItemActive();
    };
    const float width = ImGui::GetContentRegionAvail().x - 6.2F * ImGui::GetFontSize();
    ImGui::PushItemWidth(width);
    if (ImGui::BeginCombo("estimator", estimator_name(s.estimator))) {
        for (const Estimator e :
             {Estimator::patch, Estimator::dpc, Estimator::dpc_published, Estimator::pt}) {
            if (ImGui::Selectable(estimator_name(e), e == s.estimator)) {
                s.estimator = e;
                done = true;
            }
        }
        active = true;
        ImGui::EndCombo();
    }
    bool automatic = model.controls.frame_share.has_value();
    if (automatic) {
        ImGui::BeginDisabled();
        int rays = model.status().rays;
        ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic);
        ImGui::EndDisabled();
    } else {
        // Rays change from frame to frame, nothing has to be prepared.
        int rays = model.controls.rays.value_or(s.rays);
        if (ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic)) {
            model.controls.rays = rays;
            model.hand_over();
        }
    }
    if (ImGui::Checkbox("auto", &automatic)) {
        model.controls.frame_share =
            automatic ? std::optional<double>(choices.budget) : std::nullopt;
        model.hand_over();
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("as many rays as a share of each frame allows");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(width - ImGui::GetCursorPosX() + ImGui::GetStyle().WindowPadding.x);
    if (ImGui::SliderFloat("budget", &choices.budget, 0.1F, 0.9F, "%.2f of a frame") && automatic) {
        model.controls.frame_share = choices.budget;
        model.hand_over();
    }
    ImGui::SliderInt("order", &s.order, 0, 50, s.order == 0 ? "no limit" : "%d");
    item();
    ImGui::SliderInt("images", &s.specular_order, 0, 5, "order %d");
    item();
    ImGui::SliderFloat("tau", &s.response_time_s, 0.03F, 5, "%.2f s", ImGuiSliderFlags_Logarithmic);
    item();
    ImGui::SliderFloat("lambda", &s.patch_size_m, 0.2F, 2, "%.2f m", ImGuiSliderFlags_Logarithmic);
    item();
    ImGui::SliderFloat("frames", &s.frame_rate_hz, 5, 60, "%.0f a second");
    item();
    const auto view = model.view();
    float length_s = s.ir_length_s.value_or(view ? static_cast<float>(view->length_s) : 1.0F);
    if (ImGui::SliderFloat("length", &length_s, 0.1F, 6, "%.2f s")) s.ir_length_s = length_s;
    item();
    int ambisonic_order = model.setting().ambisonic_order;
    ImGui::SliderInt("ambisonics", &ambisonic_order, 1, 3, "order %d");
    if (ImGui::IsItemEdited()) {
        done = true;
        active = false;
    }
    ImGui::PopItemWidth();
    choices.draft = active && !done ? std::optional(s) : std::nullopt;
    if (done) {
        s.rays = model.controls.rays.value_or(s.rays);
        model.set_simulation(s, ambisonic_order);
    }
}

void draw_absorption(const Material& material, ImVec2 size) {
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::Dummy(size);
    draw->AddRectFilled(corner, {corner.x + size.x, corner.y + size.y},
                        packed({0.06F, 0.07F, 0.085F}), 3);
    const auto x = [&](std::size_t b) {
        return corner.x + size.x * (static_cast<float>(b) + 0.5F) / kBandCount;
    };
    const auto y = [&](float share) { return corner.y + size.y - 3 - share * (size.y - 6); };
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const float half = 0.36F * size.x / kBandCount;
        draw->AddRectFilled({x(b) - half, y(material.absorption[b])}, {x(b) + half, y(0)},
                            packed(band_colour(b), 0.85F), 2);
        if (b > 0)
            draw->AddLine({x(b - 1), y(material.scattering[b - 1])},
                          {x(b), y(material.scattering[b])}, packed({0.85F, 0.87F, 0.9F}), 1.5F);
    }
}

void draw_surface(Model& model, Choices& choices) {
    if (!model.surface()) {
        ImGui::TextWrapped("Click a surface in the picture to change what it is made of.");
    } else {
        const Material material = model.surface_material();
        ImGui::ColorButton("##colour",
                           {material_colour(material).x, material_colour(material).y,
                            material_colour(material).z, 1},
                           ImGuiColorEditFlags_NoTooltip);
        ImGui::SameLine();
        ImGui::Text("%s, %.1f m2", material.name.c_str(),
                    static_cast<double>(model.surface()->area_m2));
        draw_absorption(material, {ImGui::GetContentRegionAvail().x, 3.2F * ImGui::GetFontSize()});
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("bars: absorption, 63 Hz to 8 kHz; line: scattering");
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 7.5F * ImGui::GetFontSize());
        if (ImGui::BeginCombo("##material", "change to ...", ImGuiComboFlags_HeightLarge)) {
            for (const LibraryMaterial& entry : model.library()) {
                ImGui::ColorButton(
                    ("##" + entry.material.name).c_str(),
                    {material_colour(entry.material).x, material_colour(entry.material).y,
                     material_colour(entry.material).z, 1},
                    ImGuiColorEditFlags_NoTooltip, {ImGui::GetFontSize(), ImGui::GetFontSize()});
                ImGui::SameLine();
                if (ImGui::Selectable(entry.material.name.c_str(),
                                      entry.material.name == material.name))
                    model.give_material(entry.material, choices.everywhere);
                if (ImGui::IsItemHovered()) {
                    ImGui::BeginTooltip();
                    draw_absorption(entry.material,
                                    {14 * ImGui::GetFontSize(), 4 * ImGui::GetFontSize()});
                    ImGui::TextUnformatted(entry.source.c_str());
                    ImGui::EndTooltip();
                }
            }
            ImGui::EndCombo();
        }
        ImGui::SameLine();
        ImGui::Checkbox("all alike", &choices.everywhere);
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("every surface of %s, not this one only", material.name.c_str());
    }
    ImGui::BeginDisabled(!model.can_undo());
    if (ImGui::SmallButton("undo")) model.undo();
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(!model.can_redo());
    if (ImGui::SmallButton("redo")) model.redo();
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::SmallButton("save scene")) model.save_scene();
    ImGui::SameLine();
    if (ImGui::SmallButton("save response")) model.save_response();
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("impulse response as WAV and ISO 3382 report as JSON, of what is shown");
}

void draw_view_choices(Model& model, Choices& choices) {
    ImGui::Checkbox("rays", &choices.rays);
    ImGui::SameLine();
    ImGui::Checkbox("solid", &choices.look.solid);
    ImGui::SameLine();
    ImGui::Checkbox("edges", &choices.look.edges);
    ImGui::SameLine();
    ImGui::Checkbox("see in", &choices.look.cut_away);
    ImGui::TextUnformatted("energy on the walls");
    for (const auto& [heat, name, meaning] :
         {std::tuple{Heat::none, "off", "materials"},
          std::tuple{Heat::whole, "all", "what the patches radiate altogether"},
          std::tuple{Heat::pulse, "pulse", "a pulse spreading, slowed down 30 times"}}) {
        ImGui::SameLine(0, 6);
        if (toggle(name, choices.heat == heat)) choices.heat = heat;
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", meaning);
    }
    ImGui::Checkbox("walls stop me", &model.collides);
}

}  // namespace

void draw_top_bar(Model& model, Choices& choices, Camera& camera) {
    const PlayStatus& status = model.status();
    ImGui::AlignTextToFramePadding();
    ImGui::PushFont(ImGui::GetIO().Fonts->Fonts[1]);
    ImGui::TextUnformatted(model.scene_file().stem().string().c_str());
    ImGui::PopFont();
    ImGui::SameLine(0, 16);
    const auto view = model.view();
    const std::string busy = model.busy();
    if (status.preparing || !busy.empty()) {
        // Dots that come and go: it is alive.
        constexpr std::array<const char*, 4> kDots{"", " .", " ..", " ..."};
        const auto dots = static_cast<std::size_t>(3 * ImGui::GetTime()) % kDots.size();
        ImGui::TextColored({1, 0.8F, 0.3F, 1}, "%s%s", busy.empty() ? "preparing" : busy.c_str(),
                           kDots[dots]);
    } else if (view && view->source < view->sources.size()) {
        const float distance_m =
            glm::distance(view->listener.position, view->sources[view->source]);
        const bool direct = !view->response.paths.empty() && view->response.paths[0].order == 0;
        const RoomParameters parameters = room_parameters(view->response);
        std::string text = model.scene().sources[view->source].name +
                           formatted(" %.1f m away, ", static_cast<double>(distance_m)) +
                           (direct ? "in sight" : "not in sight");
        if (parameters[4].t30_s) text += formatted(", T30 %.2f s", *parameters[4].t30_s);
        if (parameters[4].c80_db) text += formatted(", C80 %.1f dB", *parameters[4].c80_db);
        ImGui::TextUnformatted(text.c_str());
    }
    const float buttons = 25 * ImGui::GetFontSize();
    ImGui::SameLine(std::max(ImGui::GetCursorPosX(), ImGui::GetWindowWidth() - buttons));
    if (model.scene().listener.path) {
        if (toggle("walk by path", model.follows_path())) {
            if (model.follows_path())
                model.take_listener(status.listener);
            else
                model.follow_path();
        }
        ImGui::SameLine();
    }
    if (toggle("from the ears", camera.first_person)) camera.first_person = !camera.first_person;
    ImGui::SameLine();
    if (toggle("freeze", model.frozen)) model.frozen = !model.frozen;
    ImGui::SameLine();
    const std::string recording =
        model.heard().recording ? formatted("stop %.0f s", model.heard().recorded_s) : "record";
    if (toggle(recording.c_str(), model.heard().recording)) model.toggle_recording();
    ImGui::SameLine();
    if (toggle("keys ?", choices.help)) choices.help = !choices.help;
}

void draw_controls(Model& model, Choices& choices) {
    if (section("Sources")) {
        for (std::size_t s = 0; s < model.controls.sources.size(); ++s) draw_source(model, s);
        draw_parts(model);
    }
    if (section("Surface")) draw_surface(model, choices);
    if (section("Show")) draw_view_choices(model, choices);
    if (section("Simulation")) draw_settings(model, choices);
}

void draw_help(Choices& choices) {
    static constexpr std::array<std::pair<const char*, const char*>, 21> kKeys{{
        {"w s a d", "walk, step aside (shift: run)"},
        {"arrows", "turn, look up and down"},
        {"drag", "turn the view; right button: look around"},
        {"wheel", "nearer, farther; middle button: shift"},
        {"drag a source", "move it, the listener too"},
        {"click a wall", "choose it, then a material"},
        {"v", "from the ears, from outside"},
        {"t", "walk by the scene's path again"},
        {"c", "walls stop me, or not"},
        {"1 2 3", "direct, early, late on and off"},
        {"m", "mute, unmute"},
        {"x", "to the other setting, A or B"},
        {"f", "freeze the plots"},
        {"p", "rays on and off"},
        {"e", "energy on the walls: off, all, pulse"},
        {"g", "solid, wire"},
        {"ctrl z, ctrl y", "undo, redo"},
        {"r", "record what is heard"},
        {"ctrl s", "save the scene as edited"},
        {"page up, down", "another scene of the folder"},
        {"?  ctrl q", "this; quit"},
    }};
    ImGui::SetNextWindowPos(
        {0.5F * ImGui::GetIO().DisplaySize.x, 0.45F * ImGui::GetIO().DisplaySize.y},
        ImGuiCond_Always, {0.5F, 0.5F});
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

void draw_messages(const Model& model, ImVec2 corner, double now_s) {
    constexpr double kShown_s = 6;
    constexpr double kErrorShown_s = 20;
    ImDrawList* draw = ImGui::GetForegroundDrawList();
    for (auto message = model.messages().rbegin(); message != model.messages().rend(); ++message) {
        if (now_s > message->time_s + (message->is_error ? kErrorShown_s : kShown_s)) continue;
        const ImVec2 size =
            ImGui::CalcTextSize(message->text.c_str(), nullptr, false, 42 * ImGui::GetFontSize());
        corner.y -= size.y + 14;
        draw->AddRectFilled(
            {corner.x, corner.y}, {corner.x + size.x + 16, corner.y + size.y + 10},
            packed(message->is_error ? Colour(0.45F, 0.10F, 0.10F) : Colour(0.10F, 0.20F, 0.28F),
                   0.92F),
            5);
        draw->AddText(nullptr, 0, {corner.x + 8, corner.y + 5}, packed({1, 1, 1}),
                      message->text.c_str(), nullptr, 42 * ImGui::GetFontSize());
    }
}

}  // namespace aula
