#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "apps/window/model/camera.h"
#include "apps/window/model/model.h"
#include "apps/window/plots.h"
#include "apps/window/view3d.h"

namespace aula {

/// How the patches' energies are seen.
enum class Heat { none, whole, pulse };

/// What is shown, and how; kept from one session to the next.
struct Choices {
    RoomStyle look;
    bool rays = true;
    Heat heat = Heat::none;
    PlotChoice plots;
    bool everywhere = false;  ///< a material goes to all surfaces of the same
    bool help = false;
    float budget = 0.6F;              ///< of a frame's time, for "auto"
    int text_percent = 100;           ///< of the size that goes with the window's
    std::string material_search;      ///< what names of materials are to hold
    std::optional<Simulation> draft;  ///< a setting whose slider is being dragged

    float zoom() const { return static_cast<float>(text_percent) / 100; }
    void larger_text(int steps) { text_percent = std::clamp(text_percent + 10 * steps, 50, 300); }
};

/// A small button that looks pressed while something is on; whether it was clicked.
bool toggle(const char* label, bool on);

/// Scene, place, what one hears in a line, and buttons.
void draw_top_bar(Model& model, Choices& choices, Camera& camera);

/// Sources, parts, settings, surface, view.
void draw_controls(Model& model, Choices& choices);

/// Levels, loads and counts. Keeps what falls slowly.
class Meters {
 public:
    void draw(const Model& model);

 private:
    double level_db_ = -120;
    double peak_db_ = -120;
    double peak_time_s_ = 0;
};

/// The keys.
void draw_help(Choices& choices);

/// What there was to say, for some seconds.
void draw_messages(const Model& model, ImVec2 corner, float width, double now_s);

/// What the last item means, while the mouse rests on it.
void tooltip(const char* text);

/// A text, cut with "..." where it is wider than the room for it.
std::string fitting(const std::string& text, float width);

}  // namespace aula
