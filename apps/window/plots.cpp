#include "apps/window/plots.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <optional>

#include "apps/documents/parameter_text.h"
#include "apps/drawing/plan_drawing.h"
#include "apps/output/formatted.h"
#include "apps/window/gl/colours.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"
#include "apps/window/view/level_walk.h"
#include "aula/engine/room_acoustics.h"

namespace aula {

namespace {

constexpr double kEarly_s = 0.15;
constexpr double kStep_s = 0.005;
constexpr double kEarlyStep_s = 0.001;

ImFont* small_font() { return ImGui::GetIO().Fonts->Fonts.back(); }

/// The range of a horizontal axis, and the unit of its labels.
struct Axis {
    double from = 0;
    double to = 1;
    bool in_metres = false;  ///< otherwise in seconds
};

/// A plot of levels in dB over time or distance, with axes.
class Plot {
 public:
    /// From 0 to `to_s`.
    Plot(const char* title, const char* unit, ImVec2 size, double to_s, float bottom_db,
         float top_db)
        : Plot(title, unit, size, Axis{0, to_s}, bottom_db, top_db) {}

    Plot(const char* title, const char* unit, ImVec2 size, const Axis& axis, float bottom_db,
         float top_db)
        : draw_(ImGui::GetWindowDrawList()),
          axis_(axis),
          bottom_db_(bottom_db),
          top_db_(top_db),
          line_height_(ImGui::GetFontSize()) {
        const ImVec2 corner = ImGui::GetCursorScreenPos();
        ImGui::Dummy(size);
        const std::string shown_title = fitting(title, size.x);
        draw_->AddText(corner, packed({0.86F, 0.89F, 0.93F}), shown_title.c_str());
        const float title_width = ImGui::CalcTextSize(shown_title.c_str()).x + 8;
        ImGui::PushFont(small_font());
        small_height_ = ImGui::GetFontSize();
        if (title_width + ImGui::CalcTextSize(unit).x <= size.x)
            draw_->AddText({corner.x + title_width, corner.y + 2}, packed({0.55F, 0.6F, 0.66F}),
                           unit);
        const float margin = ImGui::CalcTextSize("-100").x + 6;
        low_ = {corner.x + margin, corner.y + 1.35F * line_height_};
        high_ = {corner.x + size.x - 6, corner.y + size.y - 1.5F * small_height_};
        draw_->AddRectFilled(low_, high_, packed({0.06F, 0.07F, 0.085F}), 3);
        grid();
        draw_->PushClipRect(low_, high_, true);
    }
    ~Plot() {
        draw_->PopClipRect();
        ImGui::PopFont();
    }
    Plot(const Plot&) = delete;
    Plot& operator=(const Plot&) = delete;

    float x(double at) const {
        const double share = (at - axis_.from) / (axis_.to - axis_.from);
        return low_.x + static_cast<float>(share) * (high_.x - low_.x);
    }
    float y(float level_db) const {
        return high_.y - (level_db - bottom_db_) / (top_db_ - bottom_db_) * (high_.y - low_.y);
    }

    void line(const std::vector<float>& levels_db, double step_s, ImU32 colour, float width) {
        points_.clear();
        for (std::size_t i = 0; i < levels_db.size(); ++i) {
            const double time_s = (static_cast<double>(i) + 0.5) * step_s;
            if (time_s > axis_.to + step_s) break;
            points_.push_back({x(time_s), y(std::max(levels_db[i], bottom_db_ - 20))});
        }
        draw_->AddPolyline(points_.data(), static_cast<int>(points_.size()), colour, 0, width);
    }

    void band(const std::deque<LevelWalk::Point>& walk, std::size_t band, ImU32 colour,
              float width) {
        points_.clear();
        for (const LevelWalk::Point& point : walk)
            points_.push_back(
                {x(point.walked_m), y(std::max(point.level_db[band], bottom_db_ - 20))});
        draw_->AddPolyline(points_.data(), static_cast<int>(points_.size()), colour, 0, width);
    }

    void area(const std::vector<float>& levels_db, double step_s, ImU32 colour) {
        for (std::size_t i = 0; i < levels_db.size(); ++i) {
            const double begin_s = static_cast<double>(i) * step_s;
            if (begin_s > axis_.to) break;
            if (levels_db[i] <= bottom_db_) continue;
            draw_->AddRectFilled({x(begin_s), y(levels_db[i])},
                                 {std::max(x(begin_s + step_s), x(begin_s) + 1), high_.y}, colour);
        }
    }

    void stem(double time_s, float level_db, ImU32 colour, float width) {
        if (level_db <= bottom_db_) return;
        const ImVec2 top{x(time_s), y(level_db)};
        draw_->AddLine(top, {top.x, high_.y}, colour, width);
        draw_->AddCircleFilled(top, 1 + width, colour, 8);
    }

    void segment(double from_s, float from_db, double to_s, float to_db, ImU32 colour) {
        draw_->AddLine({x(from_s), y(from_db)}, {x(to_s), y(to_db)}, colour, 2);
    }

    /// Where the pointer is on the horizontal axis, marked by a line; empty beside the plot.
    std::optional<double> pointed_at() {
        if (!ImGui::IsWindowHovered() || !ImGui::IsMouseHoveringRect(low_, high_)) return {};
        const float at = ImGui::GetMousePos().x;
        draw_->AddLine({at, low_.y}, {at, high_.y}, packed({0.55F, 0.6F, 0.66F}));
        return axis_.from +
               (axis_.to - axis_.from) * static_cast<double>((at - low_.x) / (high_.x - low_.x));
    }

    /// A right-aligned line of text; line 0 is the top.
    void note(int line, const std::string& text, ImU32 colour) {
        const float width = ImGui::CalcTextSize(text.c_str()).x;
        draw_->AddText(
            {high_.x - width - 6, low_.y + 3 + static_cast<float>(line) * (small_height_ + 2)},
            colour, text.c_str());
    }

 private:
    void grid() {
        const ImU32 colour = packed({0.16F, 0.18F, 0.21F});
        const ImU32 text = packed({0.55F, 0.6F, 0.66F});
        for (float level_db = bottom_db_; level_db <= top_db_ + 0.1F; level_db += 10) {
            draw_->AddLine({low_.x, y(level_db)}, {high_.x, y(level_db)}, colour);
            if (std::fmod(level_db - top_db_, 20.0F) != 0) continue;
            const std::string label = fixed_text(static_cast<double>(level_db), 0);
            draw_->AddText({low_.x - 4 - ImGui::CalcTextSize(label.c_str()).x,
                            y(level_db) - 0.5F * small_height_},
                           text, label.c_str());
        }
        constexpr std::array kSteps{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0};
        const float widest = 1.4F * ImGui::CalcTextSize("100 ms").x;
        const double step = *std::find_if(kSteps.begin(), kSteps.end() - 1,
                                          [&](double s) { return x(s) - x(0) >= widest; });
        for (double i = std::ceil(axis_.from / step); i * step <= axis_.to * 1.0001; ++i) {
            const float at = x(i * step);
            draw_->AddLine({at, low_.y}, {at, high_.y}, colour);
            const std::string label = axis_.in_metres ? formatted("%g m", i * step)
                                      : step < 0.1    ? formatted("%.0f ms", i * step * 1000)
                                                      : formatted("%.1f s", i * step);
            const float width = ImGui::CalcTextSize(label.c_str()).x;
            draw_->AddText({std::min(at - width / 2, high_.x - width), high_.y + 2}, text,
                           label.c_str());
        }
    }

    ImDrawList* draw_;
    Axis axis_;
    float bottom_db_;
    float top_db_;
    float line_height_;
    float small_height_ = 0;
    ImVec2 low_;
    ImVec2 high_;
    std::vector<ImVec2> points_;
};

const Colour kDirect{1.0F, 1.0F, 1.0F};
const Colour kSpecular{1.0F, 0.70F, 0.25F};
const Colour kDiffuse{0.30F, 0.62F, 0.86F};
const Colour kOther{0.95F, 0.45F, 0.75F};

float up_to_ten(float level_db) { return 10 * std::ceil(level_db / 10); }

void draw_impulse_response(const FrameView& view, ImVec2 size, double to_s) {
    float loudest = 1e-6F;
    for (const float p : view.impulse_response) loudest = std::max(loudest, p);
    for (const SoundPath& path : view.response.paths)
        loudest = std::max(loudest, std::sqrt(squared_pressure(path.energy.max())));
    const float top_db = up_to_ten(20 * std::log10(loudest));
    Plot plot("Impulse response", "dB re 1 m", size, to_s, top_db - 80, top_db);
    std::vector<float> levels_db;
    for (const float p : view.impulse_response)
        levels_db.push_back(20 * std::log10(std::max(p, 1e-9F)));
    plot.area(levels_db, view.length_s / static_cast<double>(levels_db.size()),
              packed(kDiffuse, 0.9F));
    for (auto path = view.response.paths.rbegin(); path != view.response.paths.rend(); ++path) {
        const float level_db =
            energy_db(squared_pressure(static_cast<double>(path->energy.sum())) / kBandCount);
        plot.stem(view.response.arrival_s(*path), level_db,
                  packed(path->order == 0 ? kDirect : kSpecular, path->order == 0 ? 1 : 0.8F),
                  path->order == 0 ? 2.0F : 1.0F);
    }
    plot.note(0, "direct", packed(kDirect));
    plot.note(1, "image sources", packed(kSpecular));
    plot.note(2, "reverberation", packed(kDiffuse));
}

std::string band_name(std::size_t band) {
    if (band == kAllBands) return "all octaves";
    const auto centre = static_cast<double>(kBandCentres_hz[band]);
    return centre < 1000 ? formatted("%.0f Hz", centre) : formatted("%.0f kHz", centre / 1000);
}

std::string noise_text(const FrameNoise& noise, std::size_t band) {
    const auto relative = noise.relative(band);
    return relative ? formatted("%.1f %%", 100 * *relative) : std::string("-");
}

void draw_energy(const Model& model, const FrameView& view, ImVec2 size, double to_s,
                 std::size_t band) {
    const double step_s = to_s <= kEarly_s ? kEarlyStep_s : kStep_s;
    const EnergyCurve curve = energy_curve(view.response, band, step_s);
    float loudest_db = kSilence_db;
    for (const float level_db : curve.diffuse_db) loudest_db = std::max(loudest_db, level_db);
    for (const DiscreteArrival& arrival : curve.arrivals)
        loudest_db = std::max(loudest_db, arrival.level_db);
    const float top_db = loudest_db > kSilence_db ? up_to_ten(loudest_db) : 0;
    const std::string title = "Energy, " + band_name(band);
    Plot plot(title.c_str(), to_s <= kEarly_s ? "dB in 1 ms" : "dB in 5 ms", size, to_s,
              top_db - 70, top_db);
    plot.area(curve.diffuse_db, step_s, packed(kDiffuse, 0.8F));
    for (auto arrival = curve.arrivals.rbegin(); arrival != curve.arrivals.rend(); ++arrival)
        plot.stem(
            arrival->time_s, arrival->level_db,
            packed(arrival->order == 0 ? kDirect : kSpecular, arrival->order == 0 ? 1 : 0.85F),
            arrival->order == 0 ? 2.0F : 1.0F);
    plot.note(0, "frame noise " + noise_text(model.setting().noise, band),
              packed({0.8F, 0.84F, 0.9F}));
    const auto& other = model.other_setting();
    if (!other.view) return;
    plot.line(energy_curve(other.view->response, band, step_s).diffuse_db, step_s,
              packed(kOther, 0.9F), 1.5F);
    plot.note(
        1, std::string(model.active() == 0 ? "B" : "A") + " noise " + noise_text(other.noise, band),
        packed(kOther));
}

void draw_decay(const Model& model, const FrameView& view, ImVec2 size, double to_s,
                std::size_t band) {
    Plot plot("Decay", "dB, Schroeder", size, to_s, -70, 0);
    // The selected octave, else 1 kHz as in the bar at the top.
    const std::size_t of = band == kAllBands ? 4 : band;
    for (std::size_t b = 0; b < kBandCount; ++b)
        plot.line(decay_curve_db(view.response, b, kStep_s), kStep_s,
                  packed(band_colour(b), b == of ? 1.0F : 0.38F), b == of ? 2.5F : 1.0F);
    if (band == kAllBands)
        plot.line(decay_curve_db(view.response, band, kStep_s), kStep_s,
                  packed({0.95F, 0.95F, 0.97F}, 0.6F), 1.0F);
    // T30's slope from -5 to -35 dB.
    if (const auto t30_s = model.parameters().octave(AcousticParameter::t30, of).value) {
        const std::vector<float> decay = decay_curve_db(view.response, of, kStep_s);
        const auto start = std::find_if(decay.begin(), decay.end(), [](float d) { return d < -5; });
        const double from_s = static_cast<double>(start - decay.begin()) * kStep_s;
        plot.segment(from_s, -5, from_s + *t30_s / 2, -35, packed({1.0F, 0.9F, 0.3F}));
        plot.note(0, formatted("T30 %.2f s at ", *t30_s) + band_name(of),
                  packed({1.0F, 0.9F, 0.3F}));
    }
    const auto& other = model.other_setting();
    if (other.view)
        plot.line(decay_curve_db(other.view->response, of, kStep_s), kStep_s, packed(kOther, 0.9F),
                  1.5F);
}

/// The levels of the direct sound where the listener walked, one curve per octave band.
void draw_walk(const LevelWalk& walk, ImVec2 size, std::size_t band) {
    constexpr float kRange_db = 50;
    const auto& points = walk.points();
    const double walked_m = points.empty() ? 0 : points.back().walked_m;
    float loudest_db = kSilence_db;
    for (const LevelWalk::Point& point : points)
        for (const float level_db : point.level_db) loudest_db = std::max(loudest_db, level_db);
    const float top_db = loudest_db > kSilence_db ? up_to_ten(loudest_db) : 0;
    const double from_m = std::max(0.0, walked_m - LevelWalk::kLength_m);
    Plot plot("Walk: direct sound", "dB re 1 m", size,
              Axis{from_m, from_m + LevelWalk::kLength_m, true}, top_db - kRange_db, top_db);
    for (std::size_t b = 0; b < kBandCount; ++b)
        plot.band(points, b, packed(band_colour(b), b == band || band == kAllBands ? 1.0F : 0.38F),
                  b == band ? 2.5F : 1.5F);
    if (walked_m == 0) plot.note(0, "walk to record the levels", packed({0.8F, 0.84F, 0.9F}));
    if (const auto at_m = plot.pointed_at()) {
        if (const LevelWalk::Point* const point = walk.nearest(*at_m))
            ImGui::SetTooltip("%s", text_of(*point).c_str());
    }
}

/// The parameters of the table: those of reports that need no ears.
constexpr std::size_t kTableParameters = static_cast<std::size_t>(AcousticParameter::iacc_early);

std::string text_of(const MeasuredValue& measured, int decimals) {
    return measured.value ? fixed_text(*measured.value, decimals) : std::string("-");
}

void cell_text(const std::string& text) {
    ImGui::TableNextColumn();
    const float room = ImGui::GetContentRegionAvail().x;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + room - ImGui::CalcTextSize(text.c_str()).x);
    ImGui::TextUnformatted(text.c_str());
}

/// Whether an octave decays for longer than the response: it has an EDT without a T30.
bool is_too_short(const PairParameters& parameters) {
    for (std::size_t b = 0; b < kBandCount; ++b)
        if (parameters.octave(AcousticParameter::edt, b).value &&
            !parameters.octave(AcousticParameter::t30, b).value)
            return true;
    return false;
}

/// The first row: the octaves, which select what the plots show, and the single number.
void draw_octaves(PlotChoice& choice) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (ImGui::Selectable("Hz", choice.band == kAllBands)) choice.band = kAllBands;
    ImGui::PushStyleVar(ImGuiStyleVar_SelectableTextAlign, {1, 0});
    for (std::size_t b = 0; b < kBandCount; ++b) {
        ImGui::TableNextColumn();
        ImGui::PushStyleColor(ImGuiCol_Text, packed(band_colour(b)));
        const auto centre = static_cast<double>(kBandCentres_hz[b]);
        const std::string name =
            centre < 1000 ? formatted("%.0f", centre) : formatted("%.0fk", centre / 1000);
        if (ImGui::Selectable(name.c_str(), choice.band == b)) choice.band = b;
        ImGui::PopStyleColor();
    }
    ImGui::PopStyleVar();
    cell_text("mean");
}

/// "1 dB", or "5 %" of the value.
std::string noticeable_text(const ParameterText& text) {
    return text.is_share ? formatted("%g %%", 100 * text.noticeable)
                         : formatted("%g ", text.noticeable) + text.unit;
}

/// Begins a row with the symbol and the unit of a parameter, as reports write them.
void begin_parameter(const ParameterText& text) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted((text.symbol + " " + text.unit).c_str());
    tooltip((text.name + ". Single number: " + text.single +
             ". Just noticeable difference: " + noticeable_text(text) + ".")
                .c_str());
}

void draw_table(const Model& model, ImVec2 size, PlotChoice& choice) {
    const PairParameters& parameters = model.parameters();
    const float top = ImGui::GetCursorPosY();
    ImGui::BeginGroup();
    ImGui::TextUnformatted("ISO 3382");
    ImGui::PushFont(small_font());
    ImGui::SameLine(0, 10);
    if (is_too_short(parameters)) {
        ImGui::TextColored({0.9F, 0.75F, 0.45F, 1}, "response of %.2f s: too short for T30",
                           model.view()->length_s);
        tooltip(
            "Where T30 is missing, the sound decays for longer than the response. A longer "
            "duration "
            "lets it decay; fewer rays and updates leave time for it.");
    } else {
        ImGui::TextDisabled("response of %.2f s; click an octave", model.view()->length_s);
    }
    ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {1, 1});
    if (ImGui::BeginTable(
            "iso", kBandCount + 2,
            ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_ScrollY,
            {size.x, top + size.y - ImGui::GetCursorPosY()})) {
        ImGui::TableSetupScrollFreeze(0, 1);
        ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed,
                                ImGui::CalcTextSize(model.compares() ? "A noise %" : "noise %").x);
        for (std::size_t b = 0; b <= kBandCount; ++b)
            ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthStretch, 1);
        draw_octaves(choice);
        for (std::size_t p = 0; p < kTableParameters; ++p) {
            const ParameterText text = parameter_text(p);
            begin_parameter(text);
            for (const MeasuredValue& value : parameters.octaves[p])
                cell_text(text_of(value, text.decimals));
            cell_text(text_of(parameters.broadband[p], text.decimals));
        }
        const ParameterText sti = parameter_text(kSpeechTransmission);
        begin_parameter(sti);
        for (std::size_t b = 0; b < kBandCount; ++b) ImGui::TableNextColumn();
        cell_text(text_of(parameters.sti, sti.decimals));
        const auto noise_row = [&](const char* name, const FrameNoise& noise) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(name);
            tooltip(
                "Frame-to-frame noise while nothing moves: relative standard deviation of the "
                "energy in windows of 20 ms.");
            for (std::size_t b = 0; b < kBandCount; ++b) {
                const auto relative = noise.relative(b);
                cell_text(relative ? formatted("%.1f", 100 * *relative) : "-");
            }
        };
        const bool a = model.active() == 0;
        noise_row(!model.compares() ? "noise %"
                  : a               ? "A noise %"
                                    : "B noise %",
                  model.setting().noise);
        if (model.compares()) {
            ImGui::PushStyleColor(ImGuiCol_Text, packed(kOther));
            noise_row(a ? "B noise %" : "A noise %", model.other_setting().noise);
            ImGui::PopStyleColor();
        }
        ImGui::EndTable();
    }
    ImGui::PopStyleVar();
    ImGui::PopFont();
    ImGui::EndGroup();
}

/// Buttons that show a pane, in place of the one that was chosen longest ago, if not all fit.
void draw_pane_choice(PlotChoice& choice, const std::vector<PaneBox>& shown) {
    constexpr std::array<const char*, kPanes.size()> kNames{"response", "energy", "decay",
                                                            "ISO 3382", "walk"};
    for (std::size_t i = 0; i < kPanes.size(); ++i) {
        if (i > 0) ImGui::SameLine(0, 4);
        const bool on = std::any_of(shown.begin(), shown.end(),
                                    [&](const PaneBox& box) { return box.pane == kPanes[i]; });
        if (toggle(kNames[i], on)) choice.order = with_first(kPanes[i], choice.order);
    }
}

}  // namespace

void draw_plots(const Model& model, PlotChoice& choice) {
    const auto view = model.view();
    if (!view) {
        ImGui::TextDisabled("the first frame is being computed");
        return;
    }
    const float gap = 10;
    const auto panes =
        panes_in(ImGui::GetContentRegionAvail().x, ImGui::GetFontSize(), gap, choice.order);
    if (panes.size() < kPanes.size()) draw_pane_choice(choice, panes);
    const float height = ImGui::GetContentRegionAvail().y;
    const double whole_s = std::max(view->length_s, 0.05);
    const double to_s = choice.early ? std::min(kEarly_s, whole_s) : whole_s;
    for (std::size_t i = 0; i < panes.size(); ++i) {
        const ImVec2 size{panes[i].width, height};
        if (i > 0) ImGui::SameLine(0, gap);
        switch (panes[i].pane) {
            case Pane::response:
                draw_impulse_response(*view, size, to_s);
                if (ImGui::IsItemClicked()) choice.early = !choice.early;
                tooltip(
                    "Level of the sound pressure at the listener after an impulse of the source; 0 "
                    "dB is "
                    "the pressure at 1 m. Click: the first 150 ms, or all.");
                break;
            case Pane::energy:
                draw_energy(model, *view, size, to_s, choice.band);
                if (ImGui::IsItemClicked()) choice.early = !choice.early;
                tooltip(
                    "Energy that arrives at the listener. Lines: direct sound and image sources; "
                    "area: "
                    "reverberation. Click: the first 150 ms, or all.");
                break;
            case Pane::decay:
                draw_decay(model, *view, size, whole_s, choice.band);
                tooltip(
                    "Decay after the source stops: backward integral of the energy response "
                    "(Schroeder), one curve per octave band. T30: extrapolated from the slope "
                    "between "
                    "-5 and -35 dB.");
                break;
            case Pane::parameters:
                draw_table(model, size, choice);
                break;
            case Pane::walk:
                draw_walk(model.level_walk(), size, choice.band);
                tooltip(
                    "Level of the direct sound at the listener over the last metres that it "
                    "walked, with its diffraction at edges and its transmission through walls, one "
                    "curve per octave band.");
                break;
        }
    }
}

}  // namespace aula
