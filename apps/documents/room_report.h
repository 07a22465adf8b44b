#pragma once

#include <string>
#include <vector>

#include "apps/documents/floor_plan.h"
#include "apps/session/offline/measured_values.h"
#include "aula/measurement.h"
#include "engine/rays/room_survey.h"

namespace aula {

/// What a report of a room's measurement contains.
struct RoomReport {
    std::string title;                   ///< name of the scene
    std::string program;                 ///< name and version
    std::string scene_hash;              ///< of all that affects results
    const Scene& scene;                  ///< as measured
    const Measurement& measurement;      ///< with parameters
    std::vector<std::string> receivers;  ///< [receiver] names
    bool frames_given = false;           ///< so that standard errors are unknown
    const RoomGeometry& room;
    const FloorPlan& plan;
    float plan_height_m = 0;                   ///< z of the plan
    std::vector<MeasuredResponse> measured{};  ///< to compare with the simulation
};

/// The report as one HTML file with inline SVG, without scripts or other files: single numbers of
/// all pairs, a plan, conditions, materials, and for each pair a table of octaves with standard
/// errors, decay curves and an echogram. The same input gives the same bytes.
std::string report_html(const RoomReport& report);

}  // namespace aula
