#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <string>
#include <tuple>

#include "apps/session/base/formatted.h"
#include "apps/window/colours.h"
#include "apps/window/panels.h"

// What can be changed: sources, surface, view, settings.

namespace aula {

namespace {

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
    tooltip("rays, patches and plots show this source");
    ImGui::SameLine();
    if (toggle("M", control.muted)) {
        control.muted = !control.muted;
        changed = true;
    }
    tooltip("mute");
    ImGui::SameLine(0, 4);
    if (toggle("S", control.solo)) {
        control.solo = !control.solo;
        changed = true;
    }
    tooltip("solo: only sources with S are heard");
    float gain_db = control.gain_db.value_or(source.gain_db);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    if (ImGui::SliderFloat("##gain", &gain_db, -40, 20, "%.1f dB")) {
        control.gain_db = gain_db;
        changed = true;
    }
    tooltip("gain: at 0 dB a full-scale signal is as loud in 1 m; ctrl and click to type a number");
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
    tooltip("what it plays; a sound file that is dropped onto the window is played, too");
    if (changed) model.hand_over();
    ImGui::PopID();
}

void draw_parts(Model& model) {
    PlayControls& controls = model.controls;
    bool changed = ImGui::Checkbox("direct", &controls.direct);
    tooltip("what comes straight from the source (1)");
    ImGui::SameLine();
    changed |= ImGui::Checkbox("early", &controls.early);
    tooltip("image sources: the first mirror reflections (2)");
    ImGui::SameLine();
    changed |= ImGui::Checkbox("late", &controls.late);
    tooltip("reverberation, from the caches (3)");
    ImGui::SetNextItemWidth(-1);
    changed |= ImGui::SliderFloat("##wet", &controls.wet, 0, 1,
                                  controls.wet == 0.5F  ? "dry - as it is - wet"
                                  : controls.wet < 0.5F ? "drier"
                                                        : "wetter");
    tooltip("direct sound against reflections; right click: as it is");
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
        controls.wet = 0.5F;
        changed = true;
    }
    if (changed) model.hand_over();
}

constexpr const char* kRaysMeaning =
    "Rays of each source in a frame. More are smoother; ctrl and click to type a number.";

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
    tooltip("two settings to compare; x goes to the other");
    for (const Preset& preset : kPresets) {
        ImGui::SameLine(0, 4);
        if (ImGui::SmallButton(preset.name)) {
            Simulation s = model.setting().simulation;
            preset.set(s);
            model.controls.rays.reset();
            model.hand_over();
            model.set_simulation(s, model.setting().ambisonic_order);
        }
        tooltip(preset.meaning);
    }

    // What is being dragged is taken over when it is let go: it takes a moment to prepare.
    Simulation s = choices.draft.value_or(model.setting().simulation);
    bool done = false;
    bool active = false;
    const auto item = [&](const char* meaning) {
        tooltip(meaning);
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
    tooltip(
        "How reverberation is computed. patch: walls keep what they radiate. dpc: the diffuse path "
        "cache, dpc-published: as it was published. pt: path tracing without a cache.");
    bool automatic = model.controls.frame_share.has_value();
    if (automatic) {
        ImGui::BeginDisabled();
        int rays = model.status().rays;
        ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic);
        tooltip(kRaysMeaning);
        ImGui::EndDisabled();
    } else {
        // Rays change from frame to frame, nothing has to be prepared.
        int rays = model.controls.rays.value_or(model.status().rays);
        if (ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic))
            model.set_rays(rays);
        tooltip(kRaysMeaning);
    }
    if (ImGui::Checkbox("auto", &automatic)) {
        model.controls.frame_share =
            automatic ? std::optional<double>(choices.budget) : std::nullopt;
        model.hand_over();
    }
    tooltip("as many rays as a share of each frame's time allows");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(width - ImGui::GetCursorPosX() + ImGui::GetStyle().WindowPadding.x);
    if (ImGui::SliderFloat("budget", &choices.budget, 0.1F, 0.9F, "%.2f of a frame") && automatic) {
        model.controls.frame_share = choices.budget;
        model.hand_over();
    }
    tooltip("the share of a frame's time that auto may take");
    ImGui::SliderInt("order", &s.order, 0, 50, s.order == 0 ? "no limit" : "%d");
    item("highest order of reflection; no limit: a ray ends where the response does");
    ImGui::SliderInt("images", &s.specular_order, 0, 5, "order %d");
    item("highest order of the image sources: mirror reflections that are computed exactly");
    ImGui::SliderFloat("tau", &s.response_time_s, 0.03F, 5, "%.2f s", ImGuiSliderFlags_Logarithmic);
    item("How long the caches look back. Longer is smoother, and slower to follow a change.");
    ImGui::SliderFloat("lambda", &s.patch_size_m, 0.2F, 2, "%.2f m", ImGuiSliderFlags_Logarithmic);
    item("Size of the patches. Smaller is finer in space, and noisier with as many rays.");
    ImGui::SliderFloat("frames", &s.frame_rate_hz, 5, 60, "%.0f a second");
    item("How often sound is propagated anew. A move is heard a frame later.");
    const auto view = model.view();
    float length_s = s.ir_length_s.value_or(view ? static_cast<float>(view->length_s) : 1.0F);
    if (ImGui::SliderFloat("length", &length_s, 0.1F, 6, "%.2f s")) s.ir_length_s = length_s;
    item("Length of the response. Reverberation that lasts longer is cut off.");
    int ambisonic_order = model.setting().ambisonic_order;
    ImGui::SliderInt("ambisonics", &ambisonic_order, 1, 3, "order %d");
    tooltip(
        "of the reverberation for the ears: a higher order is sharper in direction, and dearer");
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

/// Absorption as bars with its numbers and octaves, scattering as a line over them.
void draw_absorption(const Material& material, ImVec2 size) {
    ImDrawList* draw = ImGui::GetWindowDrawList();
    ImGui::PushFont(ImGui::GetIO().Fonts->Fonts.back());
    const float text = ImGui::GetFontSize();
    ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::Dummy({size.x, size.y + 2 * text});
    const auto label = [&](std::size_t b, float y, const std::string& number, ImU32 colour) {
        const float width = ImGui::CalcTextSize(number.c_str()).x;
        draw->AddText(
            {corner.x + size.x * (static_cast<float>(b) + 0.5F) / kBandCount - width / 2, y},
            colour, number.c_str());
    };
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const auto centre = static_cast<double>(kBandCentres_hz[b]);
        label(b, corner.y, formatted("%.2f", static_cast<double>(material.absorption[b])),
              packed({0.9F, 0.92F, 0.95F}));
        label(b, corner.y + size.y + text,
              centre < 1000 ? formatted("%.0f", centre) : formatted("%.0fk", centre / 1000),
              packed(band_colour(b)));
    }
    ImGui::PopFont();
    corner.y += text;
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

/// A square in a material's colour, at the front of a line. `size` 0: as high as a field.
void draw_swatch(const Material& material, float size) {
    const Colour colour = material_colour(material);
    ImGui::ColorButton(("##" + material.name).c_str(), {colour.x, colour.y, colour.z, 1},
                       ImGuiColorEditFlags_NoTooltip, {size, size});
    ImGui::SameLine();
}

std::string scattering_text(const Material& material) {
    std::string text;
    for (const float share : material.scattering.value)
        text += (text.empty() ? "" : ", ") + formatted("%.2f", static_cast<double>(share));
    return text;
}

void draw_search(std::string& search) {
    std::array<char, 64> text{};
    search.copy(text.data(), text.size() - 1);
    ImGui::SetNextItemWidth(-1);
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    if (ImGui::InputTextWithHint("##search", "search", text.data(), text.size()))
        search = text.data();
}

/// Whether a material's name or source holds all words that are searched for.
bool matches(const LibraryMaterial& entry, const std::string& search) {
    const auto lower = [](std::string text) {
        for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        return text;
    };
    const std::string text = lower(entry.material.name + " " + entry.source);
    std::istringstream words(lower(search));
    for (std::string word; words >> word;)
        if (text.find(word) == std::string::npos) return false;
    return true;
}

void draw_surface(Model& model, Choices& choices) {
    if (!model.surface()) {
        ImGui::TextWrapped("Click a surface in the picture to change what it is made of.");
    } else {
        const Material material = model.surface_material();
        draw_swatch(material, 0);
        ImGui::Text("%s, %.1f m2", material.name.c_str(),
                    static_cast<double>(model.surface()->area_m2));
        draw_absorption(material, {ImGui::GetContentRegionAvail().x, 3.2F * ImGui::GetFontSize()});
        tooltip(("bars: absorption, the share of energy that does not come back, with its numbers; "
                 "line: "
                 "scattering, the share of the rest that leaves in all directions: " +
                 scattering_text(material))
                    .c_str());
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 7.5F * ImGui::GetFontSize());
        if (ImGui::BeginCombo("##material", "change to ...", ImGuiComboFlags_HeightLarge)) {
            draw_search(choices.material_search);
            for (const LibraryMaterial& entry : model.library()) {
                if (!matches(entry, choices.material_search)) continue;
                draw_swatch(entry.material, ImGui::GetFontSize());
                if (ImGui::Selectable(entry.material.name.c_str(),
                                      entry.material.name == material.name))
                    model.give_material(entry.material, choices.everywhere);
                if (ImGui::IsItemHovered()) {
                    // Beside the list, which it would hide.
                    ImGui::SetNextWindowPos(
                        {ImGui::GetWindowPos().x - 6, ImGui::GetItemRectMin().y}, ImGuiCond_Always,
                        {1, 0});
                    ImGui::BeginTooltip();
                    ImGui::PushTextWrapPos(24 * ImGui::GetFontSize());
                    draw_absorption(entry.material,
                                    {24 * ImGui::GetFontSize(), 4 * ImGui::GetFontSize()});
                    ImGui::TextUnformatted(entry.source.c_str());
                    ImGui::PopTextWrapPos();
                    ImGui::EndTooltip();
                }
            }
            ImGui::EndCombo();
        }
        ImGui::SameLine();
        ImGui::Checkbox("all alike", &choices.everywhere);
        tooltip(("every surface of " + material.name + ", not this one only").c_str());
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
    tooltip("the scene file with what was changed, under another name; only comments are left out");
    ImGui::SameLine();
    if (ImGui::SmallButton("save response")) model.save_response();
    tooltip("impulse response as WAV and ISO 3382 report as JSON, of what is shown");
}

void draw_view_choices(Model& model, Choices& choices) {
    ImGui::Checkbox("rays", &choices.rays);
    tooltip("some of this frame's rays, coloured by order of reflection (p)");
    ImGui::SameLine();
    ImGui::Checkbox("solid", &choices.look.solid);
    tooltip("surfaces, or edges alone (g)");
    ImGui::SameLine();
    ImGui::Checkbox("edges", &choices.look.edges);
    tooltip("where surfaces meet");
    ImGui::SameLine();
    ImGui::Checkbox("see in", &choices.look.cut_away);
    tooltip("walls between the eye and the room are left out");
    ImGui::TextUnformatted("energy on the walls");
    for (const auto& [heat, name, meaning] :
         {std::tuple{Heat::none, "off", "materials"},
          std::tuple{Heat::whole, "all", "what the patches radiate altogether"},
          std::tuple{Heat::pulse, "pulse", "a pulse spreading, slowed down 30 times"}}) {
        ImGui::SameLine(0, 6);
        if (toggle(name, choices.heat == heat)) choices.heat = heat;
        tooltip(meaning);
    }
    ImGui::Checkbox("walls stop me", &model.collides);
    tooltip("or you walk through them (c)");
}

}  // namespace

void draw_controls(Model& model, Choices& choices) {
    if (section("Sources")) {
        for (std::size_t s = 0; s < model.controls.sources.size(); ++s) draw_source(model, s);
        draw_parts(model);
    }
    if (section("Surface")) draw_surface(model, choices);
    if (section("Show")) draw_view_choices(model, choices);
    if (section("Simulation")) draw_settings(model, choices);
}

}  // namespace aula
