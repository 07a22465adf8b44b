#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "apps/drawing/room_section.h"
#include "apps/room/offline/measured_values.h"
#include "aula/measurement.h"
#include "engine/rays/room_survey.h"

namespace aula {

/// The title and the first lines of a report, as given; empty ones are left out.
struct ReportHead {
    std::string project;  ///< the title; empty: the name of the scene
    std::string client;
    std::string author;
    std::string date;
};

/// The material that a layer of a mesh file has.
struct LayerMaterial {
    std::string file;
    std::string layer;
    std::string material;
    double area_m2 = 0;  ///< that sound reaches
};

/// What a report of a room's measurement contains.
struct RoomReport {
    ReportHead head{};
    std::string scene_name;
    std::string program;                      ///< name and version
    std::string scene_hash;                   ///< of all that affects results
    const Scene& scene;                       ///< as measured
    const Measurement& measurement;           ///< with parameters
    std::vector<std::string> receivers;       ///< [receiver] names
    std::span<const Measurement> scattering;  ///< [i] with kScatteringFactors[i]
    std::vector<char> in_room;  ///< [pair] 0 if the source or the receiver is outside the room
    bool frames_given = false;  ///< so that standard errors are unknown
    RoomGeometry room;
    RoomSection plan;
    float plan_height_m = 0;                                ///< z of the plan
    std::map<std::string, std::string> material_sources{};  ///< by name, as the scene says
    std::vector<LayerMaterial> layers{};                    ///< of the scene's mesh files
    std::vector<std::string> guesses{};                     ///< what a model did not say
    std::vector<std::string> remarks{};                     ///< besides those of the measurement
    std::vector<MeasuredResponse> measured{};               ///< to compare with the simulation
};

/// The report as one HTML file with inline SVG, without scripts or other files: single numbers of
/// all pairs, their mean and standard deviation over positions, Sabine's and Eyring's times, a
/// plan, conditions, materials with the sources of their coefficients, and for each pair a table of
/// octaves with standard errors, decay curves and an echogram. Octaves below the Schroeder
/// frequency are marked. The same input gives the same bytes.
std::string report_html(const RoomReport& report);

/// The same values as JSON: {"sources":[..],"receivers":[..],"pairs":[{"source":..,"receiver":..,
/// "bands":{..},"broadband":{..},"STI":..,"standard_errors":{..}}],"positions":{"count":..,
/// "mean":{..},"standard_deviation":{..},"counts":{..}},"schroeder_frequency_hz":..}.
std::string room_report_json(const RoomReport& report);

}  // namespace aula
