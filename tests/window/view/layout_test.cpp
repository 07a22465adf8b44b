#include "apps/window/view/layout.h"

#include <algorithm>
#include <catch2/catch.hpp>

using namespace aula;

namespace {

struct Size {
    float width;
    float height;
};

constexpr std::array<Size, 7> kSizes{
    {{640, 420}, {900, 600}, {1024, 768}, {1280, 800}, {1920, 1080}, {3840, 2160}, {1000, 2000}}};

constexpr float kText = 14;  // text height at scale 1

float em_of(const Size& size, float zoom = 1) {
    return kText * text_scale(size.width, size.height, 1, zoom);
}

bool overlap(const Box& a, const Box& b) {
    // Rounding of sums of floats: a thousandth of a pixel.
    constexpr float kMeet = 1e-3F;
    return a.x + kMeet < b.x + b.width && b.x + kMeet < a.x + a.width &&
           a.y + kMeet < b.y + b.height && b.y + kMeet < a.y + a.height;
}

bool has(const std::vector<PaneBox>& panes, Pane pane) {
    return std::any_of(panes.begin(), panes.end(),
                       [&](const PaneBox& box) { return box.pane == pane; });
}

float area(const Box& box) { return box.width * box.height; }

}  // namespace

TEST_CASE("The parts of a window of any size cover it and do not overlap") {
    for (const Size& size : kSizes) {
        for (const float zoom : {0.7F, 1.0F, 2.0F}) {
            INFO(size.width << " x " << size.height << ", zoom " << zoom);
            const float em = em_of(size, zoom);
            const Layout l = window_layout(size.width, size.height, em, 14 * em);
            const std::array<Box, 5> parts{l.bar, l.picture, l.plots, l.controls, l.meters};
            float covered = 0;
            for (std::size_t i = 0; i < parts.size(); ++i) {
                CHECK(parts[i].width > 0);
                CHECK(parts[i].height > 0);
                CHECK(parts[i].x >= 0);
                CHECK(parts[i].x + parts[i].width <= size.width + 1e-3F);
                CHECK(parts[i].y + parts[i].height <= size.height + 1e-3F);
                covered += area(parts[i]);
                for (std::size_t k = 0; k < i; ++k) CHECK_FALSE(overlap(parts[i], parts[k]));
            }
            CHECK(covered == Approx(size.width * size.height).epsilon(1e-5));  // rounding
        }
    }
}

TEST_CASE("From 900 x 600 the meters fit and the picture has at least half of the width") {
    for (const Size& size : kSizes) {
        if (size.width < 900) continue;
        INFO(size.width << " x " << size.height);
        const float em = em_of(size);
        const Layout l = window_layout(size.width, size.height, em, 14 * em);
        CHECK(l.meters.height == 14 * em);
        CHECK(l.picture.width >= 0.5F * size.width);
        CHECK(l.picture.height >= 0.4F * size.height);
    }
}

TEST_CASE("Plots have their minimum width in any window, and fill the strip") {
    constexpr float kGap = 10;
    for (const Size& size : kSizes) {
        const float em = em_of(size);
        const float width = window_layout(size.width, size.height, em, 14 * em).plots.width - em;
        for (const Pane first : kPanes) {
            INFO(size.width << " x " << size.height << ", first " << static_cast<int>(first));
            const auto panes = panes_in(width, em, kGap, with_first(first, kPaneOrder));
            REQUIRE(!panes.empty());
            float used = -kGap;
            for (const PaneBox& box : panes) {
                CHECK(box.width >= 11 * em);
                if (box.pane == Pane::parameters) CHECK(box.width >= std::min(27 * em, width));
                used += box.width + kGap;
            }
            CHECK(used == Approx(width).epsilon(1e-4));
            CHECK(has(panes, first));
            CHECK(std::is_sorted(panes.begin(), panes.end(),
                                 [](const auto& a, const auto& b) { return a.pane < b.pane; }));
        }
    }
    CHECK(panes_in(1300, kText, kGap, kPaneOrder).size() == 5);
    // Four at the size of 1280 x 800, two at 900 x 600.
    CHECK(panes_in(928, kText, kGap, kPaneOrder).size() == 4);
    CHECK(panes_in(548, kText, kGap, kPaneOrder).size() == 2);
    CHECK(panes_in(100, kText, kGap, kPaneOrder).size() == 1);
}

TEST_CASE("A pane that is chosen takes the place of the one that was chosen longest ago") {
    constexpr float kGap = 10;
    for (const float width : {928.0F, 548.0F}) {
        INFO(width);
        const auto panes = panes_in(width, kText, kGap, with_first(Pane::walk, kPaneOrder));
        CHECK(has(panes, Pane::walk));
        CHECK(has(panes, Pane::parameters));
    }
    const PaneOrder order = with_first(Pane::energy, with_first(Pane::walk, kPaneOrder));
    CHECK(order ==
          PaneOrder{Pane::energy, Pane::walk, Pane::parameters, Pane::decay, Pane::response});
}

TEST_CASE("The text scale grows with the window, the display's scale and the zoom") {
    CHECK(text_scale(1280, 800, 1, 1) == 1);
    CHECK(text_scale(900, 600, 1, 1) == 1);
    CHECK(text_scale(1920, 1080, 1, 1) == 1.1F);
    CHECK(text_scale(3840, 2160, 1, 1) == 2.15F);
    // Twice the display density doubles the window as well: the scale doubles once.
    CHECK(text_scale(2560, 1600, 2, 1) == 2);
    CHECK(text_scale(1280, 800, 1, 1.5F) == 1.5F);
    CHECK(text_scale(1280, 800, 1, 0.01F) == 0.5F);
}
