#include <algorithm>
#include <cmath>
#include <string>

#include "apps/output/formatted.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"

namespace aula {

namespace {

double decibels(double amplitude) { return amplitude > 1e-6 ? 20 * std::log10(amplitude) : -120; }

std::string level_text(double level_db, const char* unit = "") {
    return level_db <= -100 ? std::string("-") : fixed_text(level_db, 1) + unit;
}

/// A wrapped line of text.
void line(const std::string& text, const ImVec4& colour = ImGui::GetStyleColorVec4(ImGuiCol_Text)) {
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    ImGui::TextWrapped("%s", text.c_str());
    ImGui::PopStyleColor();
}

const Colour kGreen{0.20F, 0.58F, 0.35F};
const Colour kAmber{0.80F, 0.55F, 0.15F};
const Colour kRed{0.80F, 0.22F, 0.20F};

Colour load_colour(double share) { return share < 0.6 ? kGreen : share < 0.9 ? kAmber : kRed; }

/// Height of a window in which the details fit below the controls, in text heights.
constexpr float kRoomForDetails_em = 60;

double level_share(double level_db) { return std::clamp((level_db + 60) / 60, 0.0, 1.0); }

const Colour kTrace{0.95F, 0.60F, 0.30F};
const Colour kCache{0.90F, 0.45F, 0.65F};
const Colour kGather{0.45F, 0.65F, 0.95F};
const Colour kImages{0.88F, 0.83F, 0.40F};
const Colour kEdges{0.58F, 0.80F, 0.45F};
const Colour kFilters{0.50F, 0.78F, 0.72F};

void draw_details(const PlayStatus& s, double rest_s, double frame_s, const Loudness& loudness) {
    const FrameStatistics& f = s.frame;
    text_row("loudness",
             "Loudness by EBU R 128 in LUFS: of the last 0.4 s, of the last 3 s, integrated. The "
             "scenes that ship with Aula are at -23 LUFS.",
             level_text(loudness.momentary_lufs) + ", " + level_text(loudness.short_term_lufs) +
                 ", " + level_text(loudness.integrated_lufs, " LUFS"));
    text_row("true peak", "Largest level of the interpolated signal.",
             level_text(decibels(loudness.true_peak), " dBTP"));
    ImGui::PushFont(ImGui::GetIO().Fonts->Fonts.back());
    const float right = ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
    bool first = true;
    const auto part = [&](const Colour& colour, const char* name, double seconds) {
        const std::string text = formatted("%s %.1f", name, 1000 * seconds);
        // Continues the line if the text fits.
        if (!first) ImGui::SameLine(0, 6);
        if (!first && ImGui::GetCursorPosX() + ImGui::CalcTextSize(text.c_str()).x > right)
            ImGui::NewLine();
        first = false;
        ImGui::TextColored({colour.x, colour.y, colour.z, 1}, "%s", text.c_str());
    };
    part(kTrace, "trace", f.trace_s);
    part(kCache, "cache", f.cache_s);
    part(kGather, "gather", f.gather_s);
    part(kImages, "images", f.specular_s);
    part(kEdges, "edges", f.diffraction_s);
    part(kFilters, "filters", rest_s);
    ImGui::PopFont();
    line(formatted("%.2f M rays/s, %zu cache entries, %.0f MB",
                   static_cast<double>(f.segments) / std::max(s.frame_ms / 1000, frame_s) * 1e-6,
                   f.cache_entries, static_cast<double>(f.memory_bytes) * 1e-6));
    tooltip("path segments traced per second, cache entries and cache memory");
    if (f.edges > 0 || f.wall_paths > 0) {
        line(formatted("%zu edges, %zu bent paths, %zu through walls", f.edges, f.bent_paths,
                       f.wall_paths));
        tooltip(
            "edges of the scene that diffract sound; paths of the direct sound around them, and "
            "through walls, from all sources");
    }
    line(formatted("response %.0f ms old, %llu frames, %llu late", 1000 * s.frame_age_s,
                   static_cast<unsigned long long>(s.frames),
                   static_cast<unsigned long long>(s.late_frames)));
    tooltip(
        "Age of the newest response, number of frames, and frames that took longer than the frame "
        "period.");
}

}  // namespace

void Meters::draw(const Model& model) {
    constexpr double kFalls_db_s = 20;
    constexpr double kHold_s = 1.5;
    const PlayStatus& s = model.status();
    const Loudness& loudness = model.monitor_status().loudness;
    // The level rises immediately and falls slowly; the peak is held.
    const double now_db = decibels(static_cast<double>(s.peak));
    level_db_ =
        std::max(now_db, level_db_ - kFalls_db_s * static_cast<double>(ImGui::GetIO().DeltaTime));
    if (now_db >= peak_db_ || ImGui::GetTime() > peak_time_s_ + kHold_s) {
        peak_db_ = std::max(now_db, level_db_);
        peak_time_s_ = ImGui::GetTime();
    }
    const bool limited = s.limiter_gain < 0.999F;
    bar_row("level",
            "Output level relative to full scale (dBFS), with the held peak. Levels beyond full "
            "scale are limited.",
            limited ? formatted("limit %.1f", decibels(static_cast<double>(s.limiter_gain)))
                    : level_text(level_db_, " dB"),
            {{level_share(level_db_), limited          ? kRed
                                      : level_db_ > -6 ? kAmber
                                                       : kGreen}},
            level_share(peak_db_));
    const double frame_s = 1 / static_cast<double>(model.setting().simulation.frame_rate_hz);
    const FrameStatistics& f = s.frame;
    const double took_s = s.frame_ms / 1000;
    const double rest_s =
        took_s - f.trace_s - f.cache_s - f.gather_s - f.specular_s - f.diffraction_s;
    bar_row(
        "audio",
        "Rendering time relative to the duration of a block; the mark is the longest one. At 100 % "
        "the sound has gaps.",
        formatted("%.0f %%", 100 * s.load), {{s.load, load_colour(s.load)}}, s.worst_load);
    bar_row("frame",
            "Computing time of a propagation frame and the frame period. A longer frame takes "
            "effect late; the sound continues. Parts: tracing rays, updating the caches, gathering "
            "at the listener, image sources, diffraction, filters.",
            took_s < 1 ? formatted("%.0f of %.0f ms", s.frame_ms, 1000 * frame_s)
                       : formatted("%.1f s", took_s),
            {{f.trace_s / frame_s, kTrace},
             {f.cache_s / frame_s, kCache},
             {f.gather_s / frame_s, kGather},
             {f.specular_s / frame_s, kImages},
             {f.diffraction_s / frame_s, kEdges},
             {rest_s / frame_s, kFilters}});
    if (const std::string text = reduction_text(s); !text.empty()) {
        line(text, {0.9F, 0.75F, 0.45F, 1});
        tooltip(
            "Frames took longer than the frame period: the number of rays or the duration of the "
            "response is reduced. Explicitly set values are not reduced.");
    }
    if (model.is_silent()) {
        line("silent: no sound device", {0.9F, 0.75F, 0.45F, 1});
    } else if (s.underruns == 0) {
        line(formatted("no underrun in %.0f s", s.time_s), {0.5F, 0.85F, 0.6F, 1});
    } else {
        // Gaps caused by the sound server are shown less prominently.
        const bool ours = s.rendering_underruns > 0;
        const std::string when = model.last_underrun_s() < 0
                                     ? "earlier"
                                     : formatted("%.0f s ago", s.time_s - model.last_underrun_s());
        line(formatted("underruns: %llu by Aula, %llu by machine or server; last ",
                       static_cast<unsigned long long>(s.rendering_underruns),
                       static_cast<unsigned long long>(s.underruns - s.rendering_underruns)) +
                 when,
             ours ? ImVec4{1, 0.5F, 0.4F, 1} : ImVec4{0.9F, 0.75F, 0.45F, 1});
    }
    tooltip(
        "Gaps in the sound. By Aula: rendering took longer than a block. By machine or server: the "
        "audio thread was scheduled late. Without a sound device the sound is computed and "
        "discarded.");
    ImGui::SetNextItemOpen(
        ImGui::GetIO().DisplaySize.y >= kRoomForDetails_em * ImGui::GetFontSize(), ImGuiCond_Once);
    if (ImGui::CollapsingHeader("Details")) draw_details(s, rest_s, frame_s, loudness);
}

}  // namespace aula
