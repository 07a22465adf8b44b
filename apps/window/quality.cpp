#include <string>

#include "apps/output/formatted.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"

// The settings of the simulation, in words of sound design; tooltips add those of
// docs/algorithm.md.

namespace aula {

namespace {

/// What a quality spends, as --quality has it.
const char* meaning_of(Quality quality) {
    switch (quality) {
        case Quality::draft:
            return "Up to 250 rays per source and frame, for slow machines. Offline rendering and "
                   "maps take a quarter of the time of \"normal\".";
        case Quality::normal:
            return "Up to 1000 rays per source and frame. Offline, a second of sound takes about a "
                   "second of two processors.";
        case Quality::fine:
            break;
    }
    return "Up to 1000 rays per source and frame. Offline always as many; maps until their errors "
           "are small.";
}

/// Names of the estimators in the window.
const char* method_name(Estimator estimator) {
    switch (estimator) {
        case Estimator::patch:
            return "patches";
        case Estimator::dpc:
            return "path cache";
        case Estimator::dpc_published:
            return "path cache, as published";
        case Estimator::pt:
            break;
    }
    return "no cache";
}

/// Chooses the estimator. Returns true when it has changed.
bool choose_method(Estimator& chosen, const char* label) {
    if (!ImGui::BeginCombo(label, method_name(chosen))) return false;
    bool changed = false;
    for (const Estimator e :
         {Estimator::patch, Estimator::dpc, Estimator::dpc_published, Estimator::pt}) {
        if (ImGui::Selectable(method_name(e), e == chosen)) {
            chosen = e;
            changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

/// The quality, which replaces numbers of rays, and the two settings.
void draw_presets(Model& model) {
    constexpr const char* kMeaning = "What may be spent on this scene, as --quality has it.";
    row("quality", kMeaning, "", [&](const char*) {
        for (const Quality quality : {Quality::draft, Quality::normal, Quality::fine}) {
            if (quality != Quality::draft) ImGui::SameLine(0, 4);
            const Simulation& now = model.setting().simulation;
            if (toggle(quality_name(quality), now.quality == quality && !now.rays))
                model.set_quality(quality);
            tooltip(meaning_of(quality));
        }
        return false;
    });
    row("compare", "Two settings, A and B; x switches.", "", [&](const char*) {
        for (const std::size_t slot : {0U, 1U}) {
            if (slot == 1) ImGui::SameLine(0, 4);
            if (toggle(slot == 0 ? " A " : " B ", model.active() == slot) && model.active() != slot)
                model.switch_setting();
            tooltip("Two settings, A and B; x switches.");
        }
        return false;
    });
}

/// Rays, which apply in the next frame without preparation, and their automatic number.
void draw_rays(Model& model, Choices& choices) {
    bool automatic = model.controls().frame_share.has_value();
    int rays =
        automatic ? model.status().rays : model.controls().rays.value_or(model.status().rays);
    ImGui::BeginDisabled(automatic);
    if (row("rays",
            "Rays per source and frame. More rays reduce noise. Ctrl and click to type a number.",
            std::to_string(rays), [&](const char* label) {
                return bare_slider(label, &rays, 100, 20000, ImGuiSliderFlags_Logarithmic);
            }))
        model.set_rays(rays);
    ImGui::EndDisabled();
    constexpr const char* kMeaning =
        "Adapts the rays so that a frame takes this share of its period.";
    row("auto rays", kMeaning, formatted("%.0f %%", 100 * static_cast<double>(choices.budget)),
        [&](const char* label) {
            const float width = ImGui::CalcItemWidth();
            bool changed = ImGui::Checkbox("##auto", &automatic);
            tooltip(kMeaning);
            ImGui::SameLine();
            ImGui::SetNextItemWidth(width - ImGui::GetFrameHeight() -
                                    ImGui::GetStyle().ItemSpacing.x);
            changed |= bare_slider(label, &choices.budget, 0.1F, 0.9F, "%.2f") && automatic;
            if (changed)
                model.set_control(&PlayControls::frame_share,
                                  automatic ? std::optional<double>(choices.budget) : std::nullopt);
            return changed;
        });
}

}  // namespace

void draw_quality(Model& model, Choices& choices) {
    draw_presets(model);
    draw_rays(model, choices);
    // A dragged value applies at the release of the slider: preparing it takes time.
    Simulation s = choices.draft.value_or(model.setting().simulation);
    bool done = false;
    bool active = false;
    const auto slider = [&](const char* name, const char* meaning, const std::string& value,
                            const auto& control) {
        const bool changed = row(name, meaning, value, control);
        done |= ImGui::IsItemDeactivatedAfterEdit();
        active |= ImGui::IsItemActive();
        return changed;
    };
    constexpr ImGuiSliderFlags kLogarithmic = ImGuiSliderFlags_Logarithmic;
    const auto number = [](const char* format, float value) {
        return formatted(format, static_cast<double>(value));
    };
    slider("bounces", "Reflections of a ray (reflection order). No limit: as long as the response.",
           s.order == 0 ? "no limit" : std::to_string(s.order),
           [&](const char* label) { return bare_slider(label, &s.order, 0, 50); });
    slider("early bounces",
           "Exact reflections at flat walls (image sources, specular order), heard as \"early\".",
           std::to_string(s.specular_order),
           [&](const char* label) { return bare_slider(label, &s.specular_order, 0, 5); });
    const auto view = model.view();
    float length_s = s.ir_length_s.value_or(view ? static_cast<float>(view->length_s) : 1.0F);
    if (slider("duration", "Length of the response. Reverberation that is longer is cut off.",
               number("%.2f s", length_s), [&](const char* label) {
                   return bare_slider(label, &length_s, 0.1F, Simulation::kMaxIrLength_s, "%.2f");
               }))
        s.ir_length_s = length_s;
    done |= row("method",
                "Estimator of the reverberation. Patches (patch): energy that pieces of the walls "
                "radiate, kept between frames. Path cache (dpc): diffuse path cache, also as "
                "published (dpc-published). No cache (pt): path tracing, for comparison.",
                "", [&](const char* label) { return choose_method(s.estimator, label); });
    slider("patch size",
           "Size of the patches (lambda). Smaller patches resolve more detail, with more noise per "
           "ray.",
           number("%.2f m", s.patch_size_m), [&](const char* label) {
               return bare_slider(label, &s.patch_size_m, 0.2F, 2, "%.2f", kLogarithmic);
           });
    slider("smoothing",
           "Averaging time of the caches (tau). A longer time reduces noise and slows the response "
           "to changes.",
           number("%.2f s", s.response_time_s), [&](const char* label) {
               return bare_slider(label, &s.response_time_s, 0.03F, 5, "%.2f", kLogarithmic);
           });
    slider("updates",
           "Propagation frames per second (frame rate). Movements take effect one frame later.",
           number("%.0f per s", s.frame_rate_hz),
           [&](const char* label) { return bare_slider(label, &s.frame_rate_hz, 5, 60, "%.0f"); });
    int ambisonic_order = model.setting().ambisonic_order;
    if (row("ambisonics",
            "Order of the binaural reverberation. A higher order resolves directions better and "
            "costs more.",
            formatted("order %d", ambisonic_order),
            [&](const char* label) { return bare_slider(label, &ambisonic_order, 1, 3); })) {
        done = true;
        active = false;
    }
    choices.draft = active && !done ? std::optional(s) : std::nullopt;
    if (done) {
        if (model.controls().rays) s.rays = model.controls().rays;
        model.set_simulation(s, ambisonic_order);
    }
}

}  // namespace aula
