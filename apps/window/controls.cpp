#include <algorithm>
#include <array>
#include <string>
#include <tuple>

#include "apps/documents/parameter_map.h"
#include "apps/session/base/formatted.h"
#include "apps/session/offline/measurement_text.h"
#include "apps/window/colours.h"
#include "apps/window/panels.h"
#include "apps/window/view/material_search.h"

// The controls of sources, surface, view and simulation.

namespace aula {

namespace {

bool section(const char* name, bool open = true) {
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

void draw_source(Model& model, std::size_t s) {
    const Source& source = model.scene().sources[s];
    const SourceControl control = model.controls().sources[s];
    ImGui::PushID(static_cast<int>(s));
    const bool watched = model.request.source == s;
    if (ImGui::Selectable(source.name.c_str(), watched && model.scene().sources.size() > 1, 0,
                          {ImGui::GetContentRegionAvail().x - 4.2F * ImGui::GetFontSize(), 0})) {
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
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * 0.5F);
    if (ImGui::SliderFloat("##gain", &gain_db, -40, 20, "%.1f dB"))
        model.set_control(s, &SourceControl::gain_db, gain_db);
    tooltip(
        "gain: at 0 dB a full-scale signal is at full scale at 1 m; ctrl and click to type a "
        "number");
    ImGui::SameLine(0, 4);
    const std::string& chosen = model.other_signal(s);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    if (ImGui::BeginCombo("##signal", chosen.empty() ? "scene's signal" : chosen.c_str())) {
        if (ImGui::Selectable("scene's signal", chosen.empty())) model.play_own_signal(s);
        for (const TestSignal signal :
             {TestSignal::clap, TestSignal::noise_burst, TestSignal::noise, TestSignal::clicks}) {
            if (ImGui::Selectable(test_signal_name(signal), chosen == test_signal_name(signal)))
                model.play_test_signal(s, signal);
        }
        if (ImGui::Selectable("microphone", chosen == "microphone")) model.play_microphone(s);
        ImGui::EndCombo();
    }
    tooltip("signal of the source; drop a sound file onto the window to play it");
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
    ImGui::SetNextItemWidth(-1);
    float wet = model.controls().wet;
    const char* balance = wet == 0.5F ? "dry - neutral - wet" : wet < 0.5F ? "drier" : "wetter";
    if (ImGui::SliderFloat("##wet", &wet, 0, 1, balance))
        model.set_control(&PlayControls::wet, wet);
    tooltip("balance of direct sound and reflections; right click: neutral");
    if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) model.set_control(&PlayControls::wet, 0.5F);
}

constexpr const char* kRaysMeaning =
    "Rays per source and frame. More rays reduce noise; ctrl and click to type a number.";

struct Preset {
    const char* name;
    const char* meaning;
    void (*set)(Simulation&);
};

constexpr std::array<Preset, 4> kPresets{{
    {"draft", "few rays and first-order image sources, for slow machines",
     [](Simulation& s) {
         s.estimator = Estimator::patch;
         s.rays = 300;
         s.specular_order = 1;
         s.patch_size_m = 1;
         s.response_time_s = 0.5F;
     }},
    {"normal", "the defaults of a scene",
     [](Simulation& s) {
         const Simulation defaults;
         s.estimator = defaults.estimator;
         s.rays = defaults.rays;
         s.order = defaults.order;
         s.specular_order = defaults.specular_order;
         s.patch_size_m = defaults.patch_size_m;
         s.response_time_s = defaults.response_time_s;
     }},
    {"fine", "small patches, many rays",
     [](Simulation& s) {
         s.estimator = Estimator::patch;
         s.rays = 3000;
         s.specular_order = 4;
         s.patch_size_m = 0.35F;
         s.response_time_s = 1;
     }},
    {"plain", "path tracing without a cache, for comparison",
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
        tooltip("two settings to compare; x switches");
    }
    for (const Preset& preset : kPresets) {
        ImGui::SameLine(0, 4);
        if (ImGui::SmallButton(preset.name)) {
            Simulation s = model.setting().simulation;
            preset.set(s);
            model.set_control(&PlayControls::rays, std::nullopt);
            model.set_simulation(s, model.setting().ambisonic_order);
        }
        tooltip(preset.meaning);
    }

    // A dragged value applies at the release of the slider: preparing it takes time.
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
        "Estimator of the reverberation. patch: radiated energy cached per patch. dpc: diffuse "
        "path "
        "cache; dpc-published: as published. pt: path tracing without a cache.");
    bool automatic = model.controls().frame_share.has_value();
    if (automatic) {
        ImGui::BeginDisabled();
        int rays = model.status().rays;
        ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic);
        tooltip(kRaysMeaning);
        ImGui::EndDisabled();
    } else {
        // The number of rays applies in the next frame without preparation.
        int rays = model.controls().rays.value_or(model.status().rays);
        if (ImGui::SliderInt("rays", &rays, 100, 20000, "%d", ImGuiSliderFlags_Logarithmic))
            model.set_rays(rays);
        tooltip(kRaysMeaning);
    }
    if (ImGui::Checkbox("auto", &automatic)) {
        model.set_control(&PlayControls::frame_share,
                          automatic ? std::optional<double>(choices.budget) : std::nullopt);
    }
    tooltip("adapt the number of rays to a share of the frame period");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(width - ImGui::GetCursorPosX() + ImGui::GetStyle().WindowPadding.x);
    if (ImGui::SliderFloat("budget", &choices.budget, 0.1F, 0.9F, "%.2f of a frame") && automatic)
        model.set_control(&PlayControls::frame_share, choices.budget);
    tooltip("share of the frame period for auto");
    ImGui::SliderInt("order", &s.order, 0, 50, s.order == 0 ? "no limit" : "%d");
    item("highest reflection order; no limit: rays end at the length of the response");
    ImGui::SliderInt("images", &s.specular_order, 0, 5, "order %d");
    item("highest order of the image sources: exact specular reflections");
    ImGui::SliderFloat("tau", &s.response_time_s, 0.03F, 5, "%.2f s", ImGuiSliderFlags_Logarithmic);
    item(
        "Averaging time of the caches. A longer time reduces noise and slows the response to "
        "changes.");
    ImGui::SliderFloat("lambda", &s.patch_size_m, 0.2F, 2, "%.2f m", ImGuiSliderFlags_Logarithmic);
    item("Size of the patches. Smaller patches resolve more detail, with more noise per ray.");
    ImGui::SliderFloat("frame rate", &s.frame_rate_hz, 5, 60, "%.0f Hz");
    item("Propagation frames per second. Movements take effect one frame later.");
    const auto view = model.view();
    float length_s = s.ir_length_s.value_or(view ? static_cast<float>(view->length_s) : 1.0F);
    if (ImGui::SliderFloat("length", &length_s, 0.1F, Simulation::kMaxIrLength_s, "%.2f s"))
        s.ir_length_s = length_s;
    item("Length of the response. Longer reverberation is truncated.");
    int ambisonic_order = model.setting().ambisonic_order;
    ImGui::SliderInt("ambisonics", &ambisonic_order, 1, 3, "order %d");
    tooltip(
        "Ambisonic order of the binaural reverberation. A higher order resolves directions better "
        "and "
        "costs more.");
    if (ImGui::IsItemEdited()) {
        done = true;
        active = false;
    }
    ImGui::PopItemWidth();
    choices.draft = active && !done ? std::optional(s) : std::nullopt;
    if (done) {
        s.rays = model.controls().rays.value_or(s.rays);
        model.set_simulation(s, ambisonic_order);
    }
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
    const Colour colour = material_colour(material);
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
            for (const LibraryMaterial& entry : model.library()) {
                if (!matches(entry, choices.material_search)) continue;
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
    ImGui::SameLine();
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

void draw_map_controls(Model& model, MapPanel& map) {
    const float width = ImGui::GetContentRegionAvail().x - 6.2F * ImGui::GetFontSize();
    ImGui::PushItemWidth(width);
    if (ImGui::BeginCombo("parameter", parameter_text(map.choice.parameter).symbol.c_str())) {
        for (const std::size_t parameter : kMappedParameters)
            if (ImGui::Selectable(parameter_text(parameter).name.c_str(),
                                  parameter == map.choice.parameter))
                map.choice.parameter = parameter;
        ImGui::EndCombo();
    }
    tooltip(parameter_text(map.choice.parameter).name.c_str());
    ImGui::BeginDisabled(map.choice.parameter == kSpeechTransmission);
    const auto octave = [](std::size_t band) { return band_name(band) + " Hz"; };
    if (ImGui::BeginCombo("octave",
                          map.choice.band ? octave(*map.choice.band).c_str() : "broadband")) {
        if (ImGui::Selectable("broadband", !map.choice.band)) map.choice.band.reset();
        for (std::size_t band = 0; band < kBandCount; ++band)
            if (ImGui::Selectable(octave(band).c_str(), map.choice.band == band))
                map.choice.band = band;
        ImGui::EndCombo();
    }
    tooltip(
        ("broadband: the single number, " + parameter_text(map.choice.parameter).single).c_str());
    ImGui::EndDisabled();
    if (model.scene().sources.size() > 1) {
        if (ImGui::BeginCombo("source", model.scene().sources[model.request.source].name.c_str())) {
            for (std::size_t s = 0; s < model.scene().sources.size(); ++s)
                if (ImGui::Selectable(
                        (model.scene().sources[s].name + "##" + std::to_string(s)).c_str(),
                        s == model.request.source)) {
                    model.request.source = s;
                    model.watch();
                }
            ImGui::EndCombo();
        }
        tooltip("source whose map is shown");
    }
    const Bounds& bounds = model.bounds();
    ImGui::DragFloat("height", &map.height_m, 0.01F, bounds.min.z, bounds.max.z, "%.2f m");
    tooltip("z of the receivers; ctrl and click to type a number");
    ImGui::DragFloat("spacing", &map.spacing_m, 0.01F, 0.05F, 100, "%.2f m");
    tooltip("distance of the receivers; ctrl and click to type a number");
    ImGui::PopItemWidth();
    if (const auto done = model.map_progress()) {
        ImGui::ProgressBar(static_cast<float>(*done), {width, 0});
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

}  // namespace

void draw_controls(Model& model, Choices& choices) {
    if (section("Sources")) {
        for (std::size_t s = 0; s < model.controls().sources.size(); ++s) draw_source(model, s);
        draw_parts(model);
    }
    if (section("Surface")) draw_surface(model, choices);
    if (section("Show")) draw_view_choices(model, choices);
    if (section("Map", false)) draw_map_controls(model, choices.map);
    if (section("Simulation")) draw_settings(model, choices);
}

}  // namespace aula
