#include "apps/drawing/style.h"

#include <imgui.h>

#include <cmath>
#include <filesystem>
#include <utility>

namespace aula {

namespace {

#if defined(_WIN32)
constexpr const char* kFonts = "C:/Windows/Fonts";
constexpr const char* kNormal = "segoeui.ttf";
constexpr const char* kBold = "segoeuib.ttf";
#else
constexpr const char* kFonts = "/usr/share/fonts/truetype/dejavu";
constexpr const char* kNormal = "DejaVuSans.ttf";
constexpr const char* kBold = "DejaVuSans-Bold.ttf";
#endif

}  // namespace

void set_style(float scale) {
    ImGuiStyle& style = ImGui::GetStyle();
    style = {};
    ImGui::StyleColorsDark();
    style.WindowRounding = 0;
    style.WindowBorderSize = 0;
    style.FrameRounding = 3;
    style.FrameBorderSize = 1;  // makes empty boxes visible
    style.GrabRounding = 3;
    style.ItemSpacing = {6, 4};
    style.FramePadding = {5, 2};
    style.WindowPadding = {8, 6};
    style.CellPadding = {3, 1};
    ImVec4* colours = style.Colors;
    colours[ImGuiCol_WindowBg] = {0.105F, 0.117F, 0.14F, 1};
    colours[ImGuiCol_PopupBg] = {0.12F, 0.135F, 0.16F, 0.98F};
    colours[ImGuiCol_Header] = {0.17F, 0.20F, 0.25F, 1};
    colours[ImGuiCol_HeaderHovered] = {0.22F, 0.28F, 0.36F, 1};
    colours[ImGuiCol_HeaderActive] = {0.20F, 0.42F, 0.60F, 1};
    colours[ImGuiCol_Button] = {0.19F, 0.23F, 0.29F, 1};
    colours[ImGuiCol_ButtonHovered] = {0.25F, 0.36F, 0.48F, 1};
    colours[ImGuiCol_FrameBg] = {0.065F, 0.075F, 0.095F, 1};
    colours[ImGuiCol_SliderGrab] = {0.22F, 0.40F, 0.56F, 1};
    colours[ImGuiCol_SliderGrabActive] = {0.30F, 0.55F, 0.75F, 1};
    colours[ImGuiCol_TableRowBg] = {0, 0, 0, 0};
    colours[ImGuiCol_TableRowBgAlt] = {1, 1, 1, 0.035F};
    colours[ImGuiCol_Border] = {1, 1, 1, 0.14F};
    style.ScaleAllSizes(scale);
}

void load_fonts(float scale) {
    ImFontAtlas* fonts = ImGui::GetIO().Fonts;
    fonts->Clear();
    for (const auto& [name, size] : {std::pair{kNormal, 14.0F}, {kBold, 17.0F}, {kNormal, 11.5F}}) {
        const std::filesystem::path file = std::filesystem::path(kFonts) / name;
        if (std::filesystem::exists(file))
            fonts->AddFontFromFileTTF(file.string().c_str(), std::round(size * scale));
        else
            fonts->AddFontDefault();
    }
}

}  // namespace aula
