// The controls of the window, drawn without a display.

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>
#include <string>

#include "apps/window/model/model.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"
#include "apps/window/small_plan.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/wait.h"

namespace {

using namespace aula;
using namespace aula::test;

constexpr float kLeft = 400;  ///< of the panel; the picture lies beside it
constexpr float kWidth = 340;
constexpr float kHeight = 1400;

/// Dear ImGui without a window of the system.
class Gui {
 public:
    Gui() {
        ImGui::CreateContext();
        ImGuiIO& io = ImGui::GetIO();
        io.IniFilename = nullptr;
        io.DisplaySize = {kLeft + kWidth, kHeight};
        for (int font = 0; font < 3; ++font) io.Fonts->AddFontDefault();
        io.Fonts->Build();
    }
    ~Gui() { ImGui::DestroyContext(); }
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// Draws the controls with the mouse at a position.
    void draw(Model& model, Choices& choices, ImVec2 mouse) {
        ImGuiIO& io = ImGui::GetIO();
        io.DeltaTime = 0.01F;
        io.MousePos = mouse;
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({kLeft, 0});
        ImGui::SetNextWindowSize({kWidth, kHeight});
        ImGui::Begin("controls", nullptr, ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize);
        for (const char* opened : {"Map", "Standing waves"})
            ImGui::GetStateStorage()->SetInt(ImGui::GetID(opened), 1);
        draw_controls(model, choices);
        headers_.clear();
        for (const char* name : {"Sources", "Surface", "Show", "Map", "Standing waves", "Quality"})
            headers_.insert(ImGui::GetID(name));
        ImGui::End();
        ImGui::Render();
    }

    /// The item under the mouse that is not a header of a section; 0 if there is none.
    ImGuiID item() const {
        const ImGuiID id = ImGui::GetCurrentContext()->HoveredId;
        return headers_.contains(id) ? 0 : id;
    }

    /// The tooltip that is drawn; null if there is none.
    static const ImGuiWindow* tooltip() {
        const ImGuiContext& context = *ImGui::GetCurrentContext();
        for (const ImGuiWindow* window : context.Windows)
            if (window->Active && (window->Flags & ImGuiWindowFlags_Tooltip) != 0) return window;
        return nullptr;
    }

 private:
    std::set<ImGuiID> headers_;
};

WindowOptions options_of(const TemporaryFolder& folder) {
    WindowOptions options;
    options.scene_file = folder.write("room", "");
    options.playback.device = AudioDevice::kNone;
    options.playback.output = OutputFormat::mono;
    options.load = [](const std::filesystem::path&) {
        LoadedScene loaded;
        loaded.scene = small_room();
        loaded.scene.sources.push_back(loaded.scene.sources[0]);
        loaded.scene.sources[1].name = "other";
        return loaded;
    };
    return options;
}

/// Whether a vertex is near a point.
bool draws_at(const ImDrawList& list, ImVec2 point, float distance) {
    return std::any_of(list.VtxBuffer.begin(), list.VtxBuffer.end(), [&](const ImDrawVert& vertex) {
        return std::hypot(vertex.pos.x - point.x, vertex.pos.y - point.y) < distance;
    });
}

}  // namespace

TEST_CASE("Every control explains itself beside the panel while the mouse rests on it") {
    const TemporaryFolder folder;
    Model model(options_of(folder));
    model.pick(0);
    Choices choices;
    Gui gui;
    gui.draw(model, choices, {-1, -1});
    CHECK(Gui::tooltip() == nullptr);

    std::set<ImGuiID> items;
    for (float y = 2; y < kHeight; y += 5) {
        for (float x = 4; x < kWidth; x += 9) {
            gui.draw(model, choices, {kLeft + x, y});
            gui.draw(model, choices, {kLeft + x, y});
            if (gui.item() == 0) continue;
            items.insert(gui.item());
            INFO("at " << x << ", " << y);
            REQUIRE(Gui::tooltip() != nullptr);
            CHECK(Gui::tooltip()->Pos.x + Gui::tooltip()->Size.x <= kLeft);
        }
    }
    // Two sources with five items each, eighteen of the simulation, and the others.
    CHECK(items.size() > 40);
}

TEST_CASE("A quality in the window is that of --quality, in place of rays that were set") {
    const TemporaryFolder folder;
    Model model(options_of(folder));
    model.set_rays(321);
    Simulation expected = model.scene().simulation;
    expected.rays.reset();
    for (const Quality quality : {Quality::draft, Quality::normal, Quality::fine}) {
        model.set_control(&PlayControls::frame_share, 0.5);
        model.set_quality(quality);
        expected.quality = quality;
        CHECK(model.setting().simulation == expected);
        CHECK(!model.controls().rays);
        CHECK(!model.controls().frame_share);
    }
    model.set_quality(Quality::draft);
    const bool played = eventually([&] {
        model.update(0);
        return !model.changes() && model.status().full_rays == 250;
    });
    CHECK(played);
}

TEST_CASE("A slider in a row draws no text over its grab") {
    const Gui gui;
    ImGuiIO& io = ImGui::GetIO();
    io.DeltaTime = 0.01F;
    ImGui::NewFrame();
    ImGui::SetNextWindowSize({300, 300});
    ImGui::Begin("sliders");
    const auto drawn = [](const auto& item) {
        const ImDrawList& list = *ImGui::GetWindowDrawList();
        const int before = list.VtxBuffer.Size;
        item();
        return list.VtxBuffer.Size - before;
    };
    float value = 0.5F;
    const int bare = drawn([&] { bare_slider("##a", &value, 0, 1, "%.2f"); });
    CHECK(bare == drawn([&] { ImGui::SliderFloat("##b", &value, 0, 1, ""); }));
    CHECK(bare < drawn([&] { ImGui::SliderFloat("##c", &value, 0, 1, "%.2f"); }));
    ImGui::End();
    ImGui::EndFrame();
}

TEST_CASE("Ctrl and a click on a slider in a row edit its number") {
    const Gui gui;
    ImGuiIO& io = ImGui::GetIO();
    float value = 0.5F;
    bool edited = false;
    const auto frame = [&](ImVec2 mouse, bool pressed) {
        io.DeltaTime = 0.1F;
        io.MousePos = mouse;
        io.MouseDown[0] = pressed;
#if IMGUI_VERSION_NUM < 18900
        io.KeyCtrl = true;
        io.KeyMods = ImGuiKeyModFlags_Ctrl;
#else
        io.AddKeyEvent(ImGuiMod_Ctrl, true);
#endif
        ImGui::NewFrame();
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({300, 300});
        ImGui::Begin("sliders", nullptr, ImGuiWindowFlags_NoTitleBar);
        row("gain", "", "0.5",
            [&](const char* label) { return bare_slider(label, &value, 0, 1, "%.2f"); });
        const ImVec2 low = ImGui::GetItemRectMin();
        const ImVec2 high = ImGui::GetItemRectMax();
        edited = io.WantTextInput;
        ImGui::End();
        ImGui::Render();
        return ImVec2{0.5F * (low.x + high.x), 0.5F * (low.y + high.y)};
    };
    const ImVec2 middle = frame({-1, -1}, false);
    frame(middle, false);
    frame(middle, true);
    frame(middle, false);
    frame(middle, false);
    CHECK(edited);
    CHECK(value == 0.5F);
}

TEST_CASE("The small plan shows the room, the listener and the sources in its frame") {
    const TemporaryFolder folder;
    Model model(options_of(folder));
    REQUIRE(eventually([&] {
        model.update(0);
        return !model.status().sources.empty();
    }));
    const Gui gui;
    ImGui::GetIO().DeltaTime = 0.01F;
    ImGui::NewFrame();
    ImDrawList& list = *ImGui::GetForegroundDrawList();
    SmallPlan plan;
    plan.draw(model, model.scene().listener.pose, {500, 20}, 100, list);
    // Of the room of 5 x 4 m, with a margin around it.
    const float margin = 0.7F * ImGui::GetFontSize();
    REQUIRE(list.VtxBuffer.Size > 0);
    for (const ImDrawVert& vertex : list.VtxBuffer) {
        CHECK(vertex.pos.x > 500 - 100 - 2 * margin - 1);
        CHECK(vertex.pos.x < 501);
        CHECK(vertex.pos.y > 19);
        CHECK(vertex.pos.y < 20 + 80 + 2 * margin + 1);
    }
    // The listener at (3.7, 2.9), and the source at (1.2, 1.1).
    CHECK(draws_at(list, {500 - margin - 100 + 20 * 3.7F, 20 + margin + 20 * (4 - 2.9F)}, 12));
    CHECK(draws_at(list, {500 - margin - 100 + 20 * 1.2F, 20 + margin + 20 * (4 - 1.1F)}, 8));
    CHECK_FALSE(draws_at(list, {500 - margin - 50, 20 + margin + 40}, 8));
    ImGui::EndFrame();
}
