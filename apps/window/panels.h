#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "apps/documents/document_measurement.h"
#include "apps/window/gl/view3d.h"
#include "apps/window/model/model.h"
#include "apps/window/plots.h"
#include "apps/window/view/camera.h"
#include "apps/window/view/map_cells.h"

namespace aula {

/// Energies of the patches drawn on the walls: none, summed over time, or of a moving time window.
enum class EnergyOverlay { off, total, pulse };

/// The map to show and to measure.
struct MapPanel {
    bool shown = true;
    MapChoice choice;
    float height_m = static_cast<float>(kMapHeight_m);
    float spacing_m = static_cast<float>(kMapSpacing_m);
};

/// The standing waves to show.
struct WavePanel {
    bool shown = true;
    float hz = 63;
};

/// Display options. Most of them are kept from one run to the next.
struct Choices {
    RoomStyle style;
    bool rays = true;
    bool direct_paths = true;  ///< paths of the direct sound, edges that diffract it, lobes
    EnergyOverlay overlay = EnergyOverlay::off;
    PlotChoice plots;
    MapPanel map;
    WavePanel waves;
    bool everywhere = false;  ///< a material replaces that of all such surfaces
    bool help = false;
    float budget = 0.6F;              ///< share of a frame's time for "auto"
    int text_percent = 100;           ///< relative to the window's text scale
    std::string material_search;      ///< words to find in names and sources
    std::optional<Simulation> draft;  ///< while a slider is dragged

    float zoom() const { return static_cast<float>(text_percent) / 100; }
    void larger_text(int steps) { text_percent = std::clamp(text_percent + 10 * steps, 50, 300); }
};

/// A small button drawn as pressed while `on`. Returns true when clicked.
bool toggle(const char* label, bool on);

/// Draws the scene's name, one line about the response at the listener, and buttons.
void draw_top_bar(Model& model, Choices& choices, Camera& camera);

/// Draws the controls of sources, surface, view and simulation.
void draw_controls(Model& model, Choices& choices);

/// Draws the settings of the simulation.
void draw_quality(Model& model, Choices& choices);

/// Level and load meters. Keeps the decaying level and the held peak.
class Meters {
 public:
    void draw(const Model& model);

 private:
    double level_db_ = -120;
    double peak_db_ = -120;
    double peak_time_s_ = 0;
};

/// Draws the list of keys.
void draw_help(Choices& choices);

/// Draws recent messages, each for some seconds. `corner` is the lower left corner.
void draw_messages(const Model& model, ImVec2 corner, float width, double now_s);

/// The text, truncated with "..." if it is wider than `width`.
std::string fitting(const std::string& text, float width);

}  // namespace aula
