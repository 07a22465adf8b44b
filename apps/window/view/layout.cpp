#include "apps/window/view/layout.h"

#include <algorithm>
#include <cmath>

namespace aula {

namespace {

constexpr float kPlot_em = 11;
constexpr float kTable_em = 27;
constexpr float kTableShare = 0.28F;

float min_width(Pane pane, float em) {
    return em * (pane == Pane::parameters ? kTable_em : kPlot_em);
}

}  // namespace

Layout window_layout(float width, float height, float em, float meters_height) {
    const float bar = 2.3F * em;
    const float below = std::max(0.0F, height - bar);
    const float side = std::min(24 * em, 0.42F * width);
    // In a small window plots and meters take at most half of the height.
    const float plots = std::min(std::clamp(0.26F * height, 13.5F * em, 24 * em), 0.5F * below);
    const float meters = std::min(meters_height, 0.5F * below);
    const float left = width - side;
    return {.bar = {0, 0, width, bar},
            .picture = {0, bar, left, below - plots},
            .plots = {0, bar + below - plots, left, plots},
            .controls = {left, bar, side, below - meters},
            .meters = {left, bar + below - meters, side, meters}};
}

PaneOrder with_first(Pane first, PaneOrder order) {
    const auto at = std::find(order.begin(), order.end(), first);
    std::rotate(order.begin(), at, at + 1);
    return order;
}

std::vector<PaneBox> panes_in(float width, float em, float gap, const PaneOrder& order) {
    std::vector<PaneBox> shown;
    float used = -gap;
    for (const Pane pane : order) {
        const float min = min_width(pane, em);
        if (!shown.empty() && used + gap + min > width) break;
        shown.push_back({pane, min});
        used += gap + min;
    }
    std::sort(shown.begin(), shown.end(),
              [](const PaneBox& a, const PaneBox& b) { return a.pane < b.pane; });
    // In a wide strip the table takes a fixed share. The plots share the remaining width.
    float left = width - used;
    for (PaneBox& box : shown) {
        if (box.pane != Pane::parameters) continue;
        const float more =
            shown.size() == 1 ? left : std::clamp(kTableShare * width - box.width, 0.0F, left);
        box.width += more;
        left -= more;
    }
    const auto plots = static_cast<float>(std::count_if(
        shown.begin(), shown.end(), [](const PaneBox& b) { return b.pane != Pane::parameters; }));
    for (PaneBox& box : shown)
        if (box.pane != Pane::parameters) box.width += left / plots;
    return shown;
}

float text_scale(float width, float height, float display_scale, float zoom) {
    constexpr float kWidth = 1600;
    constexpr float kHeight = 1000;
    constexpr float kStep = 20;  // fonts are rebuilt at each step
    const float of_window = std::min(width / kWidth, height / kHeight);
    const float scale = zoom * std::max({1.0F, display_scale, of_window});
    return std::clamp(std::round(kStep * scale) / kStep, 0.5F, 6.0F);
}

}  // namespace aula
