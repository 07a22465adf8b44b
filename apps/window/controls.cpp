#include <algorithm>
#include <array>
#include <string>
#include <tuple>

#include "apps/documents/parameter_map.h"
#include "apps/drawing/plan_drawing.h"
#include "apps/output/formatted.h"
#include "apps/room/offline/measurement_text.h"
#include "apps/window/gl/colours.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"
#include "engine/model/material_search.h"

// The controls of sources, surface, view and map.

namespace aula {

namespace {

bool section(const char* name, bool open = true) {
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

bool choose_signal(Model& model, std::size_t s, const char* label) {
    const std::string& chosen = model.other_signal(s);
    if (!ImGui::BeginCombo(label, chosen.empty() ? "scene's signal" : chosen.c_str())) return false;
    if (ImGui::Selectable("scene's signal", chosen.empty())) model.play_own_signal(s);
    for (const TestSignal signal :
         {TestSignal::clap, TestSignal::noise_burst, TestSignal::noise, TestSignal::clicks}) {
        if (ImGui::Selectable(test_signal_name(signal), chosen == test_signal_name(signal)))
            model.play_test_signal(s, signal);
    }
    if (ImGui::Selectable("microphone", chosen == "microphone")) model.play_microphone(s);
    ImGui::EndCombo();
    return true;
}

void draw_source(Model& model, std::size_t s) {
    const Source& source = model.scene().sources[s];
    const SourceControl control = model.controls().sources[s];
    ImGui::PushID(static_cast<int>(s));
    const bool watched = model.request.source == s;
    const ImGuiStyle& style = ImGui::GetStyle();
    const float buttons = ImGui::CalcTextSize("MS").x + 4 * style.FramePadding.x + 4;
    if (ImGui::Selectable(source.name.c_str(), watched && model.scene().sources.size() > 1, 0,
                          {ImGui::GetContentRegionAvail().x - buttons - style.ItemSpacing.x, 0})) {
        model.request.source = s;
        model.watch();
    }
    tooltip("select for rays, patches and plots");
    ImGui::SameLine();
    if (toggle("M", control.muted)) model.set_control(s, &SourceControl::muted, !control.muted);
    tooltip("mute");
    ImGui::SameLine(0, 4);
    if (toggle("S", control.solo)) model.set_control(s, &SourceControl::solo, !control.solo);
    tooltip("solo: mute all sources without S");
    float gain_db = control.gain_db.value_or(source.gain_db);
    if (row("gain",
            "At 0 dB a full-scale signal is at full scale at 1 m. Ctrl and click to type a number.",
            fixed_text(static_cast<double>(gain_db), 1) + " dB",
            [&](const char* label) { return bare_slider(label, &gain_db, -40, 20, "%.1f"); }))
        model.set_control(s, &SourceControl::gain_db, gain_db);
    row("signal", "Drop a sound file onto the window to play it.", "",
        [&](const char* label) { return choose_signal(model, s, label); });
    ImGui::PopID();
}

void draw_parts(Model& model) {
    const auto part = [&](const char* name, bool PlayControls::*control) {
        bool audible = model.controls().*control;
        if (ImGui::Checkbox(name, &audible)) model.set_control(control, audible);
    };
    part("direct", &PlayControls::direct);
    tooltip("direct sound (1)");
    ImGui::SameLine();
    part("early", &PlayControls::early);
    tooltip("image sources: early specular reflections (2)");
    ImGui::SameLine();
    part("late", &PlayControls::late);
    tooltip("reverberation (3)");
    float wet = model.controls().wet;
    if (row("balance", "Direct sound and reflections. Right click: neutral.",
            wet == 0.5F  ? "neutral"
            : wet < 0.5F ? "drier"
                         : "wetter",
            [&](const char* label) { return bare_slider(label, &wet, 0, 1, "%.2f"); }))
        model.set_control(&PlayControls::wet, wet);
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) model.set_control(&PlayControls::wet, 0.5F);
}

/// Draws absorption as labelled bars per octave band, scattering as a line.
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

/// Draws a square in a material's colour; the next item follows on the same line. `size` 0: frame
/// height.
void draw_swatch(const Material& material, float size) {
    const Colour colour = material_look(material.name).colour;
    ImGui::ColorButton(("##" + material.name).c_str(), {colour.x, colour.y, colour.z, 1},
                       ImGuiColorEditFlags_NoTooltip, {size, size});
    tooltip("colour of the material in the picture");
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

void draw_surface(Model& model, Choices& choices) {
    if (!model.surface()) {
        ImGui::TextWrapped("Click a surface in the picture to change its material.");
    } else {
        const Material material = model.surface_material();
        draw_swatch(material, 0);
        ImGui::Text("%s, %.1f m2", material.name.c_str(),
                    static_cast<double>(model.surface()->area_m2));
        draw_absorption(material, {ImGui::GetContentRegionAvail().x, 3.2F * ImGui::GetFontSize()});
        tooltip(
            ("bars: absorption coefficient; line: scattering coefficient, the diffuse share of the "
             "reflected energy: " +
             scattering_text(material))
                .c_str());
        ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 8.5F * ImGui::GetFontSize());
        if (ImGui::BeginCombo("##material", "change to ...", ImGuiComboFlags_HeightLarge)) {
            draw_search(choices.material_search);
            const MaterialSearch search(choices.material_search);
            for (const LibraryMaterial& entry : model.library()) {
                if (!search.finds(entry)) continue;
                draw_swatch(entry.material, ImGui::GetFontSize());
                if (ImGui::Selectable(entry.material.name.c_str(),
                                      entry.material.name == material.name))
                    model.give_material(entry.material, choices.everywhere);
                if (ImGui::IsItemHovered()) {
                    // Beside the list, so as not to cover it.
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
        tooltip("materials that ship with Aula, found by words of their names and sources");
        ImGui::SameLine();
        ImGui::Checkbox("all surfaces", &choices.everywhere);
        tooltip(("apply to all surfaces of " + material.name).c_str());
    }
    ImGui::BeginDisabled(!model.can_undo());
    if (ImGui::SmallButton("undo")) model.undo();
    tooltip("undo the last change of a material (ctrl z)");
    ImGui::EndDisabled();
    ImGui::SameLine();
    ImGui::BeginDisabled(!model.can_redo());
    if (ImGui::SmallButton("redo")) model.redo();
    tooltip("redo the undone change (ctrl y)");
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::SmallButton("save scene")) model.save_scene();
    tooltip("write the edited scene to a new file, without comments");
    same_line_for("save response");
    if (ImGui::SmallButton("save response")) model.save_response();
    tooltip("write the shown impulse response as WAV and its ISO 3382 report as JSON");
}

void draw_view_choices(Model& model, Choices& choices) {
    ImGui::Checkbox("rays", &choices.rays);
    tooltip("some rays of this frame, coloured by reflection order (p)");
    ImGui::SameLine();
    ImGui::Checkbox("solid", &choices.style.solid);
    tooltip("surfaces, or a wireframe (g)");
    ImGui::SameLine();
    ImGui::Checkbox("edges", &choices.style.edges);
    tooltip("edges of the surfaces");
    ImGui::SameLine();
    ImGui::Checkbox("cut away", &choices.style.cut_away);
    tooltip("omit walls between the camera and the room");
    ImGui::TextUnformatted("radiated energy");
    for (const auto& [overlay, name, meaning] :
         {std::tuple{EnergyOverlay::off, "off", "colours of the materials"},
          std::tuple{EnergyOverlay::total, "total",
                     "energy that the patches radiate, summed over time"},
          std::tuple{EnergyOverlay::pulse, "pulse",
                     "propagation of a pulse, slowed down 30 times"}}) {
        ImGui::SameLine(0, 6);
        if (toggle(name, choices.overlay == overlay)) choices.overlay = overlay;
        tooltip(meaning);
    }
    ImGui::Checkbox("collisions", &model.collides);
    tooltip("walls stop the listener (c)");
    ImGui::SameLine();
    ImGui::Checkbox("direct paths", &choices.direct_paths);
    tooltip(
        "Paths of the direct sound: straight, around edges, and dashed through walls. Brighter "
        "lines are louder. Green: edges that diffract sound; the brightest are free edges, then "
        "bends above 40 degrees. Orange: the pressure that a directive source radiates in each "
        "direction, in the selected octave. (b)");
}

bool choose_parameter(std::size_t& chosen, const char* label) {
    if (!ImGui::BeginCombo(label, parameter_text(chosen).symbol.c_str())) return false;
    for (const std::size_t parameter : kMappedParameters)
        if (ImGui::Selectable(parameter_text(parameter).name.c_str(), parameter == chosen))
            chosen = parameter;
    ImGui::EndCombo();
    return true;
}

bool choose_octave(std::optional<std::size_t>& chosen, const char* label) {
    const auto octave = [](std::size_t band) { return band_name(band) + " Hz"; };
    if (!ImGui::BeginCombo(label, chosen ? octave(*chosen).c_str() : "broadband")) return false;
    if (ImGui::Selectable("broadband", !chosen)) chosen.reset();
    for (std::size_t band = 0; band < kBandCount; ++band)
        if (ImGui::Selectable(octave(band).c_str(), chosen == band)) chosen = band;
    ImGui::EndCombo();
    return true;
}

bool choose_source(Model& model, const char* label) {
    const auto& sources = model.scene().sources;
    if (!ImGui::BeginCombo(label, sources[model.request.source].name.c_str())) return false;
    for (std::size_t s = 0; s < sources.size(); ++s)
        if (ImGui::Selectable((sources[s].name + "##" + std::to_string(s)).c_str(),
                              s == model.request.source)) {
            model.request.source = s;
            model.watch();
        }
    ImGui::EndCombo();
    return true;
}

void draw_map_controls(Model& model, MapPanel& map) {
    row("parameter", parameter_text(map.choice.parameter).name.c_str(), "",
        [&](const char* label) { return choose_parameter(map.choice.parameter, label); });
    ImGui::BeginDisabled(map.choice.parameter == kSpeechTransmission);
    row("octave",
        ("Broadband: the single number, " + parameter_text(map.choice.parameter).single).c_str(),
        "", [&](const char* label) { return choose_octave(map.choice.band, label); });
    ImGui::EndDisabled();
    if (model.scene().sources.size() > 1)
        row("source", "Source whose map is shown.", "",
            [&](const char* label) { return choose_source(model, label); });
    const Bounds& bounds = model.bounds();
    row("height", "z of the receivers. Drag, or ctrl and click to type a number.", "",
        [&](const char* label) {
            return ImGui::DragFloat(label, &map.height_m, 0.01F, bounds.min.z, bounds.max.z,
                                    "%.2f m");
        });
    row("spacing", "Distance of the receivers. Drag, or ctrl and click to type a number.", "",
        [&](const char* label) {
            return ImGui::DragFloat(label, &map.spacing_m, 0.01F, 0.05F, 100, "%.2f m");
        });
    if (const auto done = model.map_progress()) {
        ImGui::ProgressBar(static_cast<float>(*done), {0.7F * ImGui::GetContentRegionAvail().x, 0});
        ImGui::SameLine();
        if (ImGui::SmallButton("cancel")) model.cancel_map();
        tooltip("stop the measurement; an earlier map stays");
        return;
    }
    if (ImGui::SmallButton("measure map"))
        model.start_map(double{map.height_m}, double{map.spacing_m});
    tooltip("measure all parameters of all sources in the background, as aula map does");
    if (!model.map()) return;
    ImGui::SameLine();
    ImGui::Checkbox("show map", &map.shown);
    tooltip("draw the map in the picture");
    if (!model.map_is_current()) ImGui::TextUnformatted("The map is from before the last change.");
}

void draw_wave_controls(Model& model, Choices& choices) {
    WavePanel& panel = choices.waves;
    const Bounds& bounds = model.bounds();
    row("height", "z of the picture. Drag, or ctrl and click to type a number.", "",
        [&](const char* label) {
            return ImGui::DragFloat(label, &choices.map.height_m, 0.01F, bounds.min.z, bounds.max.z,
                                    "%.2f m");
        });
    if (model.finds_standing_waves()) {
        ImGui::TextUnformatted("finding the modes ...");
        return;
    }
    if (ImGui::SmallButton("find modes")) model.start_standing_waves(double{choices.map.height_m});
    tooltip("compute the standing waves of the room at this height");
    const auto waves = model.standing_waves();
    if (!waves || !(waves->highest_hz() > 0)) return;
    ImGui::SameLine();
    ImGui::Checkbox("show waves", &panel.shown);
    tooltip("draw the level of a tone of the source in the picture, in place of a map");
    if (model.scene().sources.size() > 1)
        row("source", "Source that plays the tone.", "",
            [&](const char* label) { return choose_source(model, label); });
    row("frequency", "Of the tone. Drag, or ctrl and click to type a number.", "",
        [&](const char* label) {
            return ImGui::SliderFloat(label, &panel.hz, 20, static_cast<float>(waves->highest_hz()),
                                      "%.1f Hz");
        });
}

}  // namespace

void draw_controls(Model& model, Choices& choices) {
    if (section("Sources")) {
        for (std::size_t s = 0; s < model.controls().sources.size(); ++s) draw_source(model, s);
        draw_parts(model);
    }
    if (section("Surface")) draw_surface(model, choices);
    if (section("Show")) draw_view_choices(model, choices);
    if (section("Map", false)) draw_map_controls(model, choices.map);
    if (section("Standing waves", false)) draw_wave_controls(model, choices);
    if (section("Quality")) draw_quality(model, choices);
}

}  // namespace aula
