// The controls of the window, drawn without a display.

#include <imgui.h>
#include <imgui_internal.h>

#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>

#include "apps/window/model/model.h"
#include "apps/window/panels.h"
#include "apps/window/rows.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test_scenes.h"

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
        ImGui::GetStateStorage()->SetInt(ImGui::GetID("Map"), 1);  // opened
        draw_controls(model, choices);
        headers_.clear();
        for (const char* name : {"Sources", "Surface", "Show", "Map", "Quality"})
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

}  // namespace

TEST_CASE("Every control explains itself beside the panel while the mouse rests on it") {
    const TemporaryFolder folder;
    WindowOptions options;
    options.scene_file = folder.write("room", "");
    options.session.device = AudioDevice::kNone;
    options.session.output = OutputFormat::mono;
    options.load = [](const std::filesystem::path&) {
        LoadedScene loaded;
        loaded.scene = small_room();
        loaded.scene.sources.push_back(loaded.scene.sources[0]);
        loaded.scene.sources[1].name = "other";
        return loaded;
    };
    Model model(options);
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
