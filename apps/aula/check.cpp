#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/aula/commands.h"
#include "apps/aula/room_positions.h"
#include "apps/output/formatted.h"
#include "apps/output/printable.h"
#include "apps/room/frames/ray_budget.h"
#include "apps/room/frames/signals.h"
#include "aula/engine/propagation.h"
#include "aula/engine/scene_file.h"
#include "aula/exception.h"
#include "engine/base/tolerances.h"
#include "engine/input/names.h"
#include "engine/model/unit_guess.h"
#include "engine/rays/ray_scene.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

/// The warnings of a check.
class Findings {
 public:
    explicit Findings(const Arguments& arguments) : arguments_(arguments) {}

    const Arguments& arguments() const { return arguments_; }

    /// Warnings that have been printed.
    void add(const std::vector<std::string>& printed) { any_ = any_ || !printed.empty(); }

    void warn(const std::string& line) {
        any_ = true;
        aula::warn({arguments_.scene.string() + ": " + line}, arguments_.quiet);
    }

    /// Results are meaningless, by a line or by a warning that has been printed.
    void doubt(const std::string& line) {
        warn(line);
        doubt();
    }
    void doubt() { meaningless_ = true; }

    /// The exit status.
    int status() const {
        constexpr int kMeaningless = 3;
        return meaningless_ || (any_ && arguments_.strict) ? kMeaningless : 0;
    }

 private:
    const Arguments& arguments_;
    bool any_ = false;
    bool meaningless_ = false;
};

/// Largest relative decrease of Sabine's reverberation time over the bands, 0..1, against the room
/// without openings, if the share `escape` of the reflections leaves it.
double reverberation_decrease(const RoomGeometry& room, double escape, const Medium& medium) {
    RoomSurvey tight = room.field;
    RoomSurvey leaky = room.field;
    for (std::size_t b = 0; b < kBandCount; ++b) {
        const double of_faces = std::max(
            0.0, (double{room.field.mean_absorption[b]} - room.open_share) / (1 - room.open_share));
        tight.mean_absorption[b] = static_cast<float>(of_faces);
        leaky.mean_absorption[b] = static_cast<float>(escape + (1 - escape) * of_faces);
    }
    const Bands tight_s = sabine_time_s(tight, medium);
    const Bands leaky_s = sabine_time_s(leaky, medium);
    double largest = 0;
    for (std::size_t b = 0; b < kBandCount; ++b)
        if (std::isfinite(tight_s[b]))
            largest = std::max(largest, 1 - double{leaky_s[b] / tight_s[b]});
    return largest;
}

/// Reads the signals of all sources. Throws SceneErrors: one message for each that fails.
void check_signals(const Scene& scene, Findings& findings) {
    const Arguments& arguments = findings.arguments();
    SharedSignals files(scene, arguments.playback.sample_rate_hz);
    SignalSet signals;
    std::vector<std::string> errors;
    for (std::size_t s = 0; s < scene.sources.size(); ++s) {
        try {
            signals.push_back(
                result_of("reading the sound of " + printable_line(scene.sources[s].name),
                          arguments, [&] { return files.read(s); }));
        } catch (const InputError& error) {
            // Sources can play the same file.
            if (std::find(errors.begin(), errors.end(), error.what()) == errors.end())
                errors.emplace_back(error.what());
        }
    }
    if (!errors.empty()) throw SceneErrors(std::move(errors));
    const std::vector<std::string> warnings = warnings_of(signals);
    warn(warnings, arguments.quiet);
    findings.add(warnings);
}

/// Warns of an initial position far outside the geometry that is inside in another unit.
void check_unit(const NamedPosition& item, const Bounds& bounds, Findings& findings) {
    constexpr float kFar = 20;  // diagonals; a mistake of a hundred leads beyond it in most rooms
    const float away_m = glm::length(item.position);
    if (item.time_s || !(away_m > kFar * bounds.diagonal_m())) return;
    for (const auto& [unit, per_m] : {std::pair("millimetres", 1000.0F), {"centimetres", 100.0F}}) {
        const Vec3 meant = item.position / per_m;
        if (!bounds.contains(meant)) continue;
        findings.warn(item.name + " is inside if its position is in " + unit +
                      ": in metres it is " +
                      formatted("[%g, %g, %g]", double{meant.x}, double{meant.y}, double{meant.z}));
        return;
    }
}

/// Warns of the listener and sources outside the room, once each. Without the listener at its
/// start, or without any source, there is nothing to hear.
void check_positions(const Scene& scene, const SortedPositions& sorted, Findings& findings) {
    const Bounds bounds = geometry_bounds(scene.objects);
    std::vector<std::string> reported;
    std::set<std::string> missing;
    for (const NamedPosition& item : sorted.outside) {
        if (!item.time_s) missing.insert(item.name);
        if (std::find(reported.begin(), reported.end(), item.name) != reported.end()) continue;
        reported.push_back(item.name);
        // Reading the scene has warned of positions outside the bounds.
        if (bounds.contains(item.position))
            findings.warn(outside_text(item));
        else
            check_unit(item, bounds, findings);
    }
    const std::size_t missing_sources = missing.size() - missing.count(kListener);
    if (missing.contains(kListener) || missing_sources == scene.sources.size()) findings.doubt();
}

/// Doubts the unit and the axes of a scene if others explain its size, or that all positions are
/// outside.
void check_size(const Scene& scene, Findings& findings) {
    const auto turned = [](const Bounds& bounds) {
        return Bounds{{bounds.min.x, -bounds.max.z, bounds.min.y},
                      {bounds.max.x, -bounds.min.z, bounds.max.y}};
    };
    const auto hold_all = [&](const Bounds& bounds) {
        const std::vector<NamedPosition> positions = initial_positions(scene);
        return std::all_of(positions.begin(), positions.end(), [&](const NamedPosition& item) {
            return bounds.contains(item.position);
        });
    };
    const bool has_files = std::any_of(scene.objects.begin(), scene.objects.end(),
                                       [](const Object& o) { return !o.files.empty(); });
    if (!has_files) return;
    Bounds bounds = geometry_bounds(scene.objects);
    std::string keys;
    if (const auto unit = guess_unit(glm::dvec3(bounds.max) - glm::dvec3(bounds.min))) {
        bounds = {bounds.min * static_cast<float>(unit->metres),
                  bounds.max * static_cast<float>(unit->metres)};
        keys = formatted("\"scale\": %g", unit->metres);
    }
    if (!hold_all(bounds)) {
        if (!hold_all(turned(bounds))) return;
        bounds = turned(bounds);
        keys += keys.empty() ? "\"up\": \"y\"" : " and \"up\": \"y\"";
    }
    if (keys.empty()) return;
    const Bounds given = geometry_bounds(scene.objects);
    findings.doubt("the geometry is " + size_text(given.max - given.min) + " m; with " + keys +
                   " beside \"file\" it is " + size_text(bounds.max - bounds.min) +
                   " m and holds the listener and all sources");
}

/// Doubts a scene so far from the origin that the offset of rays from surfaces is rounded to
/// nothing: from 2048 m. T30 of a box of plaster is 1.5 % off at 2100 m, and right at 2040 m.
void check_distance(const Scene& scene, Findings& findings) {
    const Bounds bounds = geometry_bounds(scene.objects);
    const Vec3 away = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
    const float away_m = std::max({away.x, away.y, away.z});
    if (!(std::nextafter(away_m, 2 * away_m) - away_m > 2 * tolerances::kOffset_m)) return;
    const Vec3 move = -glm::round(0.5F * (bounds.min + bounds.max));
    findings.doubt(
        formatted("the geometry is %.0f m from the origin, too far for the precision of "
                  "rays; move all positions, and objects by \"translate\": [%.0f, %.0f, "
                  "%.0f]",
                  double{away_m}, double{move.x}, double{move.y}, double{move.z}));
}

/// Warns of a source, or the listener, whose `places` sound cannot reach from any of `others`,
/// wherever the movable objects are. Returns false if that is so for all places.
bool check_connection(const RayScene& rays, const std::vector<NamedPosition>& places,
                      const std::vector<NamedPosition>& others, Findings& findings) {
    const std::vector<NamedPosition> missed =
        result_of(kMeasuring, findings.arguments(), [&] { return cut_off(rays, places, others); });
    if (missed.size() == places.size()) return false;
    if (missed.empty()) return true;
    findings.warn(missed[0].name + " is inside a closed body" + place_text(missed[0]) +
                  ": no sound passes its surfaces; lead the path around it");
    return true;
}

/// Warns of sources that sound cannot leave for the listener, wherever both are on their paths, and
/// of parts of the paths that are inside closed bodies. Of positions outside the room
/// check_positions() warns.
void check_audibility(const RayScene& rays, const SortedPositions& sorted, Findings& findings) {
    std::map<std::string, std::vector<NamedPosition>> places;
    for (const NamedPosition& item : sorted.inside) places[item.name].push_back(item);
    const std::vector<NamedPosition> listener = places[kListener];
    places.erase(kListener);
    if (listener.empty()) return;
    std::vector<NamedPosition> audible;
    for (const auto& [name, source] : places) {
        if (check_connection(rays, source, listener, findings)) {
            audible.insert(audible.end(), source.begin(), source.end());
        } else {
            findings.warn(name +
                          " is never audible: closed surfaces separate it from the listener");
        }
    }
    if (!audible.empty()) {
        check_connection(rays, listener, audible, findings);
    } else if (!places.empty()) {
        findings.doubt();
    }
}

/// Reports the share of reflections that escape and their effect on the reverberation time.
void check_leaks(const Scene& scene, const RayScene& rays, const SortedPositions& sorted,
                 Findings& findings) {
    // Relative error of the reverberation time; the just noticeable difference is 5 %.
    constexpr double kHarmless = 0.01;
    // Share of escaping reflections above which faces are missing: more than a slit.
    constexpr double kHoles = 0.01;
    // Share above which the results are those of another room.
    constexpr double kMeaningless = 0.1;
    // Share above which there is no room, but walls in the open.
    constexpr double kOpen = 0.5;
    const double escape = result_of(kMeasuring, findings.arguments(), [&] {
        return escape_per_reflection(rays, points_of(sorted.inside), kRoomSeed);
    });
    if (escape == 0 || rays.triangle_count() == 0) return;
    if (escape > kOpen) {
        // In the wrong unit the positions are outside.
        if (findings.status() == 0)
            std::printf("%s: %.0f %% of the reflections escape: open air\n",
                        printable_line(findings.arguments().scene.string()).c_str(), 100 * escape);
        return;
    }
    const double shorter = result_of(kMeasuring, findings.arguments(), [&] {
        return reverberation_decrease(measure_room(rays, points_of(sorted.inside), kRoomSeed),
                                      escape, scene.medium);
    });
    const std::string line =
        formatted("%.2g %% of the reflections escape, the reverberation time is %.2g %% shorter",
                  100 * escape, 100 * shorter);
    if (escape > kMeaningless) findings.doubt();
    if (shorter > kHarmless) {
        findings.warn(line + (escape > kHoles
                                  ? ": the room is open, or faces of its mesh are missing"
                                  : ": the room has a hole"));
    } else {
        std::printf("%s: %s: harmless\n",
                    printable_line(findings.arguments().scene.string()).c_str(), line.c_str());
    }
}

/// True if a point in the plane of a triangle is in the triangle.
bool is_on(const RayScene::Triangle& triangle, const Vec3& point) {
    const auto& v = triangle.vertices;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 inwards = glm::cross(triangle.normal, v[(k + 1) % 3] - v[k]);
        if (glm::dot(inwards, point - v[k]) < 0) return false;
    }
    return true;
}

using Overlaps = std::vector<CoplanarFaces::Overlap>;

/// [overlap] Share of the reflections that it has from the initial positions. An overlap in a
/// closed body, such as below a cupboard that stands on the floor, has none. A path may lead
/// through such bodies.
std::vector<double> reflections_on(const Overlaps& overlaps, const RayScene& rays,
                                   const SortedPositions& sorted) {
    std::vector<Vec3> inside;
    for (const NamedPosition& item : sorted.inside)
        if (!item.time_s) inside.push_back(item.position);
    std::multimap<std::uint32_t, std::size_t> of_triangle;  // -> overlap
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
        of_triangle.emplace(overlaps[i].heard, i);
        of_triangle.emplace(overlaps[i].covered, i);
    }
    std::vector<double> shares(overlaps.size(), 0);
    double hits = 0;
    const RandomWalks walks{.paths = 4096, .bounces = 32, .seed = kRoomSeed};
    trace_random_walks(rays, inside, walks, [&](float, const Ray& ray, const Hit& hit) {
        if (!hit.any()) return;
        ++hits;
        const auto [from, to] = of_triangle.equal_range(hit.triangle);
        const Vec3 point = rays.point(hit, ray.direction);
        for (auto o = from; o != to; ++o) {
            const auto& [covered, heard, area_m2, middle, is_layer] = overlaps[o->second];
            const std::uint32_t other = hit.triangle == heard ? covered : heard;
            if (is_on(rays.triangle(other), point)) ++shares[o->second];
        }
    });
    for (double& share : shares) share /= std::max(1.0, hits);
    return shares;
}

/// Two materials of overlaps, the heard one first, and what is common to them.
struct MaterialPair {
    double area_m2 = 0;
    double share = 0;  ///< of the reflections
    CoplanarFaces::Overlap largest;
};
using MaterialPairs = std::map<std::pair<std::uint32_t, std::uint32_t>, MaterialPair>;

/// The pairs of different materials whose overlaps change results.
MaterialPairs pairs_of(const Overlaps& overlaps, const RayScene& rays,
                       const SortedPositions& sorted, const Findings& findings) {
    MaterialPairs pairs;
    if (overlaps.empty()) return pairs;
    const std::vector<double> shares = result_of(
        kMeasuring, findings.arguments(), [&] { return reflections_on(overlaps, rays, sorted); });
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
        const CoplanarFaces::Overlap& overlap = overlaps[i];
        const std::uint32_t heard = rays.triangle(overlap.heard).material;
        const std::uint32_t covered = rays.triangle(overlap.covered).material;
        if (heard == covered || shares[i] == 0) continue;
        MaterialPair& pair = pairs[{heard, covered}];
        pair.area_m2 += overlap.area_m2;
        pair.share += shares[i];
        if (overlap.area_m2 > pair.largest.area_m2) pair.largest = overlap;
    }
    std::erase_if(pairs, [](const auto& item) {
        // Share of the reflections below which another material changes no result: a fiftieth of
        // the just noticeable difference of the reverberation time, if one absorbs all and one
        // nothing.
        constexpr double kNamed = 1e-3;
        // Parts on which third faces are heard are zero but for rounding: a square centimetre.
        constexpr double kLeast_m2 = 1e-4;
        return item.second.share < kNamed || item.second.area_m2 < kLeast_m2;
    });
    return pairs;
}

/// Faces that lie on each other: with the same corners, and of the same area.
Overlaps faces_in_contact(const RayScene& rays) {
    const auto contacts = rays.coplanar_faces().contacts();
    Overlaps faces(contacts.begin(), contacts.end());
    for (const RayScene::Twin& twin : rays.twins()) {
        const RayScene::Triangle& t = rays.triangle(twin.first);
        faces.push_back({.covered = twin.omitted,
                         .heard = twin.first,
                         .area_m2 = double{t.area_m2()},
                         .middle = (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3.0F});
    }
    return faces;
}

/// Names the materials of coplanar faces that overlap where sound is.
void check_coplanar_faces(const Scene& scene, const RayScene& rays, const SortedPositions& sorted,
                          Findings& findings) {
    if (const auto triangle = rays.coplanar_faces().not_searched())
        findings.warn("too many faces are in the plane of " +
                      quoted(scene.materials[rays.triangle(*triangle).material].name) +
                      " to search for those that overlap: rays hit either; fewer faces, or 2 mm "
                      "between them, are exact");
    const auto warn = [&](const Overlaps& overlaps, const char* between, const char* what) {
        for (const auto& [materials, pair] : pairs_of(overlaps, rays, sorted, findings)) {
            const Vec3& at = pair.largest.middle;
            findings.warn(
                formatted("%.3g m2 of ", pair.area_m2) +
                quoted(scene.materials[materials.first].name) + between +
                quoted(scene.materials[materials.second].name) +
                formatted(", as at (%.2f, %.2f, %.2f)", double{at.x}, double{at.y}, double{at.z}) +
                what);
        }
    };
    const auto overlaps = rays.coplanar_faces().overlaps();
    warn({overlaps.begin(), overlaps.end()}, " are in the plane of ",
         ": of faces that overlap, the smaller one is heard");
    warn(faces_in_contact(rays), " lie on equal faces of ",
         ": one of them is heard, on both sides; a wall with two materials needs a thickness");
}

/// Counted time of a frame, after the first one, which has no caches.
double counted_frame_s(const Scene& scene, const Simulation& simulation) {
    constexpr int kFrames = 3;
    Propagation propagation(scene, simulation);
    double sum_s = 0;
    for (int f = 0; f <= kFrames; ++f) {
        const double time_s = f / double{simulation.frame_rate_hz};
        FrameInput input{.time_s = time_s,
                         .sources = {},
                         .listeners = {scene.listener.pose_at(time_s).position}};
        for (const Source& source : scene.sources)
            input.sources.push_back(source.position_at(time_s));
        propagation.step(input);
        if (f > 0) sum_s += counted_s(propagation.statistics());
    }
    return sum_s / kFrames;
}

/// Warns of settings that cost ten times real time: a player that lowers what it can is late with
/// the rest. The time is counted (counted_s()), that of many rays is extrapolated from few.
void check_cost(const Scene& scene, Findings& findings) {
    constexpr double kMostTimes = 10;
    constexpr int kFewRays = 200;
    const Simulation& given = scene.simulation;
    const int given_rays = given.ray_count();
    constexpr int kUsualRays = Simulation::kRays;
    const int usual_order = Simulation{}.specular_order;
    const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    const int threads = std::min(given.threads.value_or(std::max(1, processors - 1)), processors);
    const bool has_few_threads = given.threads && threads < processors - 1;
    if (given_rays <= kUsualRays && given.specular_order <= usual_order && !has_few_threads) return;
    Simulation measured = given;
    measured.threads = 1;
    measured.rays = std::min(given_rays, kUsualRays);
    const auto [few_s, more_s] = result_of(kMeasuring, findings.arguments(), [&] {
        Simulation few = measured;
        few.rays = std::min(given_rays, kFewRays);
        return std::pair(counted_frame_s(scene, few), counted_frame_s(scene, measured));
    });
    const double ray_s = std::max(0.0, more_s - few_s) / (kUsualRays - kFewRays);
    const double frame_s = more_s + ray_s * (given_rays - *measured.rays);
    const double times = frame_s * double{given.frame_rate_hz} / threads;
    if (times < kMostTimes) return;
    std::string remedy = "set \"threads\" to " + std::to_string(processors);
    const auto rounded = [](double x) {
        const double digit = std::pow(10.0, std::floor(std::log10(x)));
        return std::round(x / digit) * digit;
    };
    if (given_rays > kUsualRays) {
        const double fewest = fewest_rays(scene.sources.size());
        remedy = formatted("set \"rays\" to %.0f", rounded(std::max(fewest, given_rays / times)));
    } else if (given.specular_order > usual_order) {
        remedy = "set \"specular_order\" to " + std::to_string(usual_order);
    }
    findings.warn(
        formatted("the propagation takes about %.0f times real time on ", rounded(times)) +
        counted(static_cast<std::size_t>(threads), "thread") + ": " + remedy);
}

}  // namespace

int check_scene(const Arguments& arguments) {
    Findings findings(arguments);
    LoadedScene loaded = read_scene_file(arguments.scene, arguments);
    findings.add(loaded.warnings);
    change_scene(loaded.scene, arguments);
    const Scene& scene = loaded.scene;
    check_signals(scene, findings);
    check_size(scene, findings);
    check_distance(scene, findings);
    const RayScene rays(scene);
    const SortedPositions sorted = result_of(
        kMeasuring, arguments, [&] { return sort_positions(rays, positions_along_paths(scene)); });
    check_coplanar_faces(scene, rays, sorted, findings);
    check_leaks(scene, rays, sorted, findings);
    check_positions(scene, sorted, findings);
    check_audibility(rays, sorted, findings);
    check_cost(scene, findings);
    std::size_t triangles = 0;
    for (const Object& object : scene.objects) triangles += object.triangles.size();
    std::printf("%s: %s, %s, %s, %s\n", printable_line(arguments.scene.string()).c_str(),
                findings.status() == 0 ? "ok" : "doubtful", counted(triangles, "triangle").c_str(),
                counted(scene.materials.size(), "material").c_str(),
                counted(scene.sources.size(), "source").c_str());
    return findings.status();
}

}  // namespace aula
