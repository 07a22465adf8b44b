#include "apps/plugin/editor/editor_panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "apps/drawing/plan_drawing.h"
#include "apps/output/formatted.h"
#include "apps/plugin/editor/window_system.h"
#include "apps/plugin/presets.h"

namespace aula::plugin {

namespace {

namespace fs = std::filesystem;

/// Widths in sizes of the font.
constexpr float kSidePanel_em = 17;
constexpr float kReach_em = 1.5F;  ///< from a mark, in which a press takes it

/// The plan is cut again when a place has moved so far.
constexpr float kCutStep_m = 0.1F;

/// Least level that is shown, dB re full scale.
constexpr float kLeastLevel_db = -60;

constexpr int kAcross = 1;  ///< the axis that the plan draws upwards
constexpr int kUp = 2;      ///< that of the side view

float distance(ImVec2 a, ImVec2 b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

EditorPanel::EditorPanel(EditorHost& host) : host_(host), sketch_(host.sources()) {}

EditorPanel::~EditorPanel() { end_drag(); }

bool EditorPanel::follow() {
    const RoomFiles files = host_.files();
    Shown now{.values = host_.values(),
              .files = files,
              .level_db = static_cast<int>(std::lround(std::max(host_.level_db(), kLeastLevel_db))),
              .status = host_.status()};
    sketch_.show(chosen_files(files, now.values, host_.folder()), now.values);
    auto room = sketch_.room();
    if (room != room_) {
        end_drag();
        cut_at_.reset();
    }
    room_ = std::move(room);
    now.room = room_.get();
    now.has_times = sketch_.times().has_value();
    const bool differs = now.values != shown_.values || now.files.scene != shown_.files.scene ||
                         now.level_db != shown_.level_db || now.status != shown_.status ||
                         now.room != shown_.room || now.has_times != shown_.has_times;
    shown_ = std::move(now);
    if (room_) cut();
    return differs;
}

Vec3 EditorPanel::source_place() const {
    Vec3 sum(0);
    const std::size_t sources = room_->controls.sources();
    for (std::size_t s = 0; s < sources; ++s)
        sum += room_->controls.source_pose(shown_.values, s).position;
    return sum / static_cast<float>(sources);
}

Pose EditorPanel::listener() const { return room_->controls.listener_pose(shown_.values); }

/// Cuts the room at the listener: the plan at the height of the ears.
void EditorPanel::cut() {
    const Vec3 at = listener().position;
    const bool is_free_field = room_->rays.triangle_count() == 0;
    if (is_free_field && cut_at_ && drag_) return;
    if (!is_free_field && cut_at_ && std::abs(cut_at_->y - at.y) < kCutStep_m &&
        std::abs(cut_at_->z - at.z) < kCutStep_m)
        return;
    cut_at_ = at;
    plan_ = floor_plan(room_->rays, at.z);
    side_ = side_view(room_->rays, at.y);
    if (!is_free_field) return;
    // Around what is in it, which stands still during a drag.
    constexpr float kMargin_m = 2;
    const Vec3 source = source_place();
    const Vec3 low = glm::min(source, at) - kMargin_m;
    const Vec3 high = glm::max(source, at) + kMargin_m;
    plan_.min = {low.x, low.y};
    plan_.max = {high.x, high.y};
    side_.min = {low.x, low.z};
    side_.max = {high.x, high.z};
}

void EditorPanel::draw() {
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize(io.DisplaySize);
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                        ImGuiWindowFlags_NoSavedSettings |
                                        ImGuiWindowFlags_NoBringToFrontOnFocus;
    if (ImGui::Begin("editor", nullptr, kFlags)) {
        const ImVec2 space = ImGui::GetContentRegionAvail();
        const float side = kSidePanel_em * ImGui::GetFontSize();
        draw_views({std::max(space.x - side - ImGui::GetFontSize(), 1.0F), space.y});
        ImGui::SetCursorPos({ImGui::GetWindowWidth() - side - ImGui::GetStyle().WindowPadding.x,
                             ImGui::GetStyle().WindowPadding.y});
        if (ImGui::BeginChild("side", {side, 0})) draw_side_panel();
        ImGui::EndChild();
    }
    ImGui::End();
}

/// The plan above the side view, in one scale.
void EditorPanel::draw_views(ImVec2 size) {
    if (!room_) return ImGui::TextDisabled("the room is being loaded");
    const glm::vec2 plan_m = plan_.max - plan_.min;
    const float height_m = side_.max.y - side_.min.y;
    const float gap = ImGui::GetFontSize();
    const float scale =
        std::min(size.x / std::max(plan_m.x, 0.01F),
                 std::max(size.y - gap, 1.0F) / std::max(plan_m.y + height_m, 0.01F));
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const float left = low.x + (size.x - scale * plan_m.x) / 2;
    draw_view("plan", plan_, kAcross, {left, low.y}, scale);
    draw_view("side", side_, kUp, {left, low.y + scale * plan_m.y + gap}, scale);
}

/// A view of X and the axis `up`.
void EditorPanel::draw_view(const char* name, const RoomSection& section, int up, ImVec2 low,
                            float scale) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const PlanDrawing drawing(section, low, scale);
    const ImVec2 size = drawing.size();
    draw.AddRectFilled(low, {low.x + size.x, low.y + size.y}, packed({0.05F, 0.06F, 0.08F}), 4);
    drawing.draw_walls(draw);
    const auto flat = [&](const Vec3& place) { return glm::vec2(place.x, place[up]); };
    for (std::size_t s = 0; s < room_->controls.sources(); ++s)
        drawing.draw_source(flat(room_->controls.source_pose(shown_.values, s).position),
                            kSourceColour, draw);
    const Pose head = listener();
    const Vec3 front = head.rotation()[0];
    drawing.draw_listener(flat(head.position),
                          up == kAcross ? glm::vec2(front.x, front.y) : glm::vec2(front.x, front.z),
                          draw);

    ImGui::SetCursorScreenPos(low);
    ImGui::InvisibleButton(name, {std::max(size.x, 1.0F), std::max(size.y, 1.0F)});
    const ImGuiID id = ImGui::GetID(name);
    if (ImGui::IsItemActivated())
        begin_drag(id, {drawing.at(flat(source_place())), drawing.at(flat(head.position))});
    if (!drag_ || drag_->view != id) return;
    if (!ImGui::IsItemActive()) return end_drag();
    const ImGuiIO& io = ImGui::GetIO();
    if (io.MouseDelta.x == 0 && io.MouseDelta.y == 0) return;
    const glm::vec2 to = drawing.point(io.MousePos);
    Vec3 place = drag_->is_listener ? head.position : source_place();
    place.x = to.x;
    place[up] = to.y;
    drag_to(place);
}

/// `marks`: the pixels of source and listener.
void EditorPanel::begin_drag(ImGuiID view, const std::array<ImVec2, 2>& marks) {
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const float source = distance(mouse, marks[0]);
    const float head = distance(mouse, marks[1]);
    if (std::min(source, head) > kReach_em * ImGui::GetFontSize()) return;
    drag_ = Drag{.is_listener = head < source, .view = view, .controls = {}};
}

void EditorPanel::drag_to(const Vec3& place) {
    const Control first = drag_->is_listener ? Control::listener_x : Control::source_x;
    for (const auto& [control, value] : room_->controls.moved_to(place, first, shown_.values)) {
        std::vector<Control>& begun = drag_->controls;
        if (std::find(begun.begin(), begun.end(), control) == begun.end()) {
            host_.begin_change(control);
            begun.push_back(control);
        }
        host_.change(control, value);
    }
}

void EditorPanel::end_drag() {
    if (!drag_) return;
    for (const Control control : drag_->controls) host_.end_change(control);
    drag_.reset();
}

void EditorPanel::set(Control control, float value) {
    host_.begin_change(control);
    host_.change(control, value);
    host_.end_change(control);
}

void EditorPanel::draw_side_panel() {
    draw_rooms();
    ImGui::Spacing();
    draw_times();
    ImGui::Spacing();
    draw_level();
    for (const std::string& line : {sketch_.error(), shown_.status}) {
        if (line.empty()) continue;
        ImGui::Spacing();
        ImGui::TextWrapped("%s", line.c_str());
    }
}

void EditorPanel::draw_rooms() {
    const std::vector<const char*>& labels =
        control_infos()[static_cast<std::size_t>(Control::room)].scale_points;
    auto room = static_cast<int>(std::lround(value_of(shown_.values, Control::room)));
    ImGui::SetNextItemWidth(-1);
    if (ImGui::Combo("##room", &room, labels.data(), static_cast<int>(labels.size())))
        set(Control::room, static_cast<float>(room));
    if (room != 0) {
        browsed_.reset();
        return;
    }
    const std::string file = shown_.files.scene.filename().string();
    ImGui::TextUnformatted(file.empty() ? "the default room" : file.c_str());
    ImGui::SameLine();
    if (ImGui::SmallButton(browsed_ ? "close" : "open...")) {
        const fs::path folder = shown_.files.scene.parent_path();
        const fs::path home = home_folder();
        if (browsed_)
            browsed_.reset();
        else
            browsed_ = list_folder(!folder.empty() ? folder : !home.empty() ? home : "/", drives());
    }
    if (browsed_) draw_files();
}

void EditorPanel::draw_files() {
    ImGui::BeginChild("files", {0, 12 * ImGui::GetTextLineHeightWithSpacing()}, true);
    std::optional<fs::path> folder;
    for (const auto& [path, name] : browsed_->folders)
        if (ImGui::Selectable(name.c_str())) folder = path;
    std::optional<fs::path> chosen;
    for (const auto& [path, name] : browsed_->files)
        if (ImGui::Selectable(name.c_str())) chosen = path;
    ImGui::EndChild();
    if (folder) browsed_ = list_folder(*folder, drives());
    if (!chosen) return;
    host_.choose_scene(*chosen);
    browsed_.reset();
}

void EditorPanel::draw_times() {
    const auto times = sketch_.times();
    if (!times) return ImGui::TextDisabled("T30 is being measured");
    const auto text = [](const std::optional<double>& time_s) {
        return time_s ? formatted("%.2f s", *time_s) : std::string("-");
    };
    ImGui::Text("T30, mean of 500 and 1000 Hz: %s", text(times->mid).c_str());
    double longest_s = 0.01;
    for (const auto& time : times->octaves) longest_s = std::max(longest_s, time.value_or(0));
    const float em = ImGui::GetFontSize();
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (std::size_t b = 0; b < kBandCount; ++b) {
        ImGui::Text("%5.0f Hz", static_cast<double>(kBandCentres_hz[b]));
        ImGui::SameLine(5 * em);
        ImGui::TextUnformatted(text(times->octaves[b]).c_str());
        ImGui::SameLine(9 * em);
        const ImVec2 low = ImGui::GetCursorScreenPos();
        const float width = ImGui::GetContentRegionAvail().x *
                            static_cast<float>(times->octaves[b].value_or(0) / longest_s);
        draw.AddRectFilled({low.x, low.y + 0.2F * em}, {low.x + width, low.y + 0.9F * em},
                           packed({0.30F, 0.55F, 0.75F}), 2);
        ImGui::NewLine();
    }
}

void EditorPanel::draw_level() {
    const auto level = static_cast<float>(shown_.level_db);
    const bool is_silent = level <= kLeastLevel_db;
    const std::string text =
        is_silent ? std::string("silence") : formatted("%d dB", shown_.level_db);
    ImGui::TextUnformatted("Peak of the output");
    ImGui::PushStyleColor(ImGuiCol_PlotHistogram, level > 0 ? ImVec4{0.85F, 0.25F, 0.2F, 1}
                                                            : ImVec4{0.25F, 0.6F, 0.35F, 1});
    ImGui::ProgressBar(std::clamp(1 - level / kLeastLevel_db, 0.0F, 1.0F), {-1, 0}, text.c_str());
    ImGui::PopStyleColor();
}

}  // namespace aula::plugin
