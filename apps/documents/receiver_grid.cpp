#include "apps/documents/receiver_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <set>

#include "apps/output/formatted.h"
#include "aula/exception.h"
#include "engine/rays/room_survey.h"

namespace aula {

namespace {

/// Points of a grid, before those outside of the room are left out.
constexpr double kMaxPoints = 1e6;

/// The point of a triangle that is nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
Vec3 nearest_point(const RayScene::Triangle& triangle, const Vec3& p) {
    const auto& [a, b, c] = triangle.vertices;
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 ap = p - a;
    const float d1 = glm::dot(ab, ap);
    const float d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Vec3 bp = p - b;
    const float d3 = glm::dot(ab, bp);
    const float d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
    const Vec3 cp = p - c;
    const float d5 = glm::dot(ab, cp);
    const float d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / (d4 - d3 + d5 - d6) * (c - b);
    const float sum = va + vb + vc;
    return a + vb / sum * ab + vc / sum * ac;
}

/// The middle of a cell.
glm::vec2 middle_of(const ReceiverGrid& grid, std::size_t cell) {
    return {grid.x_m + static_cast<float>(cell % grid.columns) * grid.spacing_m,
            grid.y_m + static_cast<float>(cell / grid.columns) * grid.spacing_m};
}

/// The first and the end of the lines of a grid in [from - clearance, to + clearance].
std::array<std::size_t, 2> lines_near(float from, float to, float first, float spacing,
                                      std::size_t count) {
    const auto line = [&](float at) {
        return static_cast<std::size_t>(
            std::clamp(std::ceil((at - first) / spacing), 0.0F, static_cast<float>(count)));
    };
    return {line(from - kGridClearance_m), line(std::nextafter(to + kGridClearance_m, 1e9F))};
}

/// Calls `visit` with the cells whose middles are in a triangle's bounds along x and y, or nearer
/// to them than the clearance.
template <typename Visit>
void for_each_cell(const ReceiverGrid& grid, const Bounds& bounds, const Visit& visit) {
    const auto columns =
        lines_near(bounds.min.x, bounds.max.x, grid.x_m, grid.spacing_m, grid.columns);
    const auto rows = lines_near(bounds.min.y, bounds.max.y, grid.y_m, grid.spacing_m, grid.rows);
    for (std::size_t row = rows[0]; row < rows[1]; ++row)
        for (std::size_t column = columns[0]; column < columns[1]; ++column)
            visit(column + grid.columns * row);
}

/// A place where a receiver may be.
struct Candidate {
    std::size_t cell;
    Vec3 position;

    /// By cell, then by height.
    friend bool operator<(const Candidate& a, const Candidate& b) {
        return a.cell != b.cell ? a.cell < b.cell : a.position.z < b.position.z;
    }
};

/// The candidates that are not too near to a surface. `all` is sorted.
std::vector<Candidate> away_from_surfaces(const ReceiverGrid& grid, const RayScene& rays,
                                          const std::vector<Candidate>& all) {
    std::vector<char> near(all.size(), 0);
    std::vector<std::size_t> first(grid.columns * grid.rows + 1);  // [cell] of its candidates
    for (const Candidate& candidate : all) ++first[candidate.cell + 1];
    for (std::size_t cell = 1; cell < first.size(); ++cell) first[cell] += first[cell - 1];
    for (const RayScene::Triangle& triangle : rays.triangles()) {
        Bounds bounds;
        bounds.add(triangle.vertices);
        for_each_cell(grid, bounds, [&](std::size_t cell) {
            for (std::size_t i = first[cell]; i < first[cell + 1]; ++i) {
                const Vec3& position = all[i].position;
                if (bounds.min.z - kGridClearance_m <= position.z &&
                    bounds.max.z + kGridClearance_m >= position.z &&
                    glm::distance(nearest_point(triangle, position), position) < kGridClearance_m)
                    near[i] = 1;
            }
        });
    }
    std::vector<Candidate> kept;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!near[i]) kept.push_back(all[i]);
    return kept;
}

/// Points of the air that sound reaches without passing walls: sources and listener in the room,
/// and the middles of segments of random walks from there, one for each cube of the space. The
/// walks are long enough for rooms behind rooms.
std::vector<Vec3> points_in_room(const Scene& scene, const RayScene& rays, float diagonal_m) {
    constexpr int kPaths = 1024;
    constexpr int kBounces = 64;
    const float cube_m = diagonal_m / 32;
    std::vector<Vec3> seeds{scene.listener.pose_at(0).position};
    for (const Source& source : scene.sources) seeds.push_back(source.position_at(0));
    const std::vector<char> outside = outside_room(rays, seeds, scene.simulation.seed);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < seeds.size(); ++i)
        if (!outside[i]) points.push_back(seeds[i]);
    const std::vector<Vec3> inside = points;
    std::set<std::array<int, 3>> cubes;
    trace_random_walks(rays, inside,
                       {.paths = kPaths, .bounces = kBounces, .seed = scene.simulation.seed},
                       [&](float, const Ray& ray, const Hit& hit) {
                           if (!hit.any()) return;
                           const Vec3 middle = ray.origin + hit.distance_m / 2 * ray.direction;
                           const glm::ivec3 cube = glm::floor(middle / cube_m);
                           if (cubes.insert({cube.x, cube.y, cube.z}).second)
                               points.push_back(middle);
                       });
    return points;
}

/// Gives a grid the candidates that are in the room.
void add_receivers(ReceiverGrid& grid, const Scene& scene, const RayScene& rays, float diagonal_m,
                   const std::vector<Candidate>& all) {
    const std::vector<Vec3> inside = points_in_room(scene, rays, diagonal_m);
    std::vector<Candidate> candidates = away_from_surfaces(grid, rays, all);
    std::erase_if(candidates, [&](const Candidate& candidate) {
        return std::none_of(inside.begin(), inside.end(), [&](const Vec3& point) {
            return rays.visible(candidate.position, point);
        });
    });
    // Positions outside of a room may see points inside through an opening.
    std::vector<char> outside(candidates.size() + 1, 0);
    if (escape_per_reflection(rays, inside, scene.simulation.seed) > 0) {
        std::vector<Vec3> positions{inside[0]};
        for (const Candidate& candidate : candidates) positions.push_back(candidate.position);
        outside = outside_room(rays, positions, scene.simulation.seed);
    }
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (outside[i + 1]) continue;
        grid.cells.push_back(candidates[i].cell);
        grid.receivers.push_back({.position = candidates[i].position});
    }
    if (grid.receivers.size() * scene.sources.size() > kMaxGridPairs)
        throw InputError("--spacing", "",
                         formatted("%g m makes %zu receivers for %zu sources; expected a larger "
                                   "spacing, with at most %zu pairs",
                                   double{grid.spacing_m}, grid.receivers.size(),
                                   scene.sources.size(), kMaxGridPairs));
}

/// The number of lines of a grid over `length_m`, at least 1.
double line_count(float length_m, double spacing_m) {
    // 1e-4: lengths that are a multiple of the spacing except for rounding.
    return std::max(1.0, std::floor(double{length_m} / spacing_m + 1e-4));
}

Bounds bounds_of(const RayScene& rays) {
    if (rays.triangle_count() == 0)
        throw InputError("the scene has no geometry; expected a room to map");
    Bounds bounds;
    for (const RayScene::Triangle& triangle : rays.triangles()) bounds.add(triangle.vertices);
    if (!(bounds.min.z < bounds.max.z))
        throw InputError("the geometry has no height; expected a room to map");
    return bounds;
}

/// The cells of a grid that is centred in the bounds of the geometry.
ReceiverGrid cells_of(const Bounds& bounds, double spacing_m) {
    const Vec3 size = bounds.max - bounds.min;
    const double columns = line_count(size.x, spacing_m);
    const double rows = line_count(size.y, spacing_m);
    if (columns * rows > kMaxPoints)
        throw InputError("--spacing", "",
                         formatted("%g m makes %.3g points; expected a spacing with at most %g",
                                   spacing_m, columns * rows, kMaxPoints));
    ReceiverGrid grid;
    grid.spacing_m = static_cast<float>(spacing_m);
    grid.columns = static_cast<std::size_t>(columns);
    grid.rows = static_cast<std::size_t>(rows);
    grid.x_m = (bounds.min.x + bounds.max.x - static_cast<float>((columns - 1) * spacing_m)) / 2;
    grid.y_m = (bounds.min.y + bounds.max.y - static_cast<float>((rows - 1) * spacing_m)) / 2;
    return grid;
}

/// The height of a triangle at a point of the plane; empty beside it. Steep ones have none: their
/// cells would be as far from each other as from the floor.
std::optional<float> height_at(const RayScene::Triangle& triangle, const glm::vec2& point) {
    constexpr float kSteep = 0.2F;  // vertical part of the normal: 78 degrees
    if (std::abs(triangle.normal.z) < kSteep) return std::nullopt;
    const auto& [a, b, c] = triangle.vertices;
    const auto cross = [](const glm::vec2& u, const glm::vec2& v) { return u.x * v.y - u.y * v.x; };
    const glm::vec2 ab = glm::vec2(b - a);
    const glm::vec2 ac = glm::vec2(c - a);
    const glm::vec2 ap = point - glm::vec2(a);
    const float area = cross(ab, ac);
    const float along_b = cross(ap, ac) / area;
    const float along_c = cross(ab, ap) / area;
    // Middles of cells on a common edge of two triangles belong to both; equal heights are merged.
    if (!(along_b >= 0 && along_c >= 0 && along_b + along_c <= 1)) return std::nullopt;
    return a.z + along_b * (b.z - a.z) + along_c * (c.z - a.z);
}

/// Whether a triangle belongs to a material or an object; empty: neither has the name.
std::optional<std::vector<char>> triangles_of(const Scene& scene, const RayScene& rays,
                                              const std::string& surface) {
    bool is_known = false;
    for (const Material& material : scene.materials) is_known |= material.name == surface;
    for (const Object& object : scene.objects) is_known |= object.name == surface;
    if (!is_known) return std::nullopt;
    std::vector<char> belongs;
    for (const RayScene::Triangle& triangle : rays.triangles())
        belongs.push_back(rays.material(triangle.material).name == surface ||
                          scene.objects[triangle.object].name == surface);
    return belongs;
}

/// The names that a surface can have.
std::string surface_names(const Scene& scene) {
    std::string names;
    const auto add = [&](const std::string& name) {
        if (!name.empty()) names += (names.empty() ? "" : ", ") + name;
    };
    for (const Material& material : scene.materials) add(material.name);
    for (const Object& object : scene.objects) add(object.name);
    return names;
}

}  // namespace

ReceiverGrid receiver_grid(const Scene& scene, const RayScene& rays, double height_m,
                           double spacing_m) {
    const Bounds bounds = bounds_of(rays);
    if (!(height_m > double{bounds.min.z} && height_m < double{bounds.max.z}))
        throw InputError("--height", "",
                         formatted("%g m is outside of the room; expected metres above %g and "
                                   "below %g",
                                   height_m, double{bounds.min.z}, double{bounds.max.z}));
    ReceiverGrid grid = cells_of(bounds, spacing_m);
    grid.height_m = static_cast<float>(height_m);
    grid.place = formatted("height %g m", height_m);
    std::vector<Candidate> candidates;
    for (std::size_t cell = 0; cell < grid.columns * grid.rows; ++cell)
        candidates.push_back({cell, Vec3(middle_of(grid, cell), grid.height_m)});
    add_receivers(grid, scene, rays, bounds.diagonal_m(), candidates);
    if (grid.cells.empty())
        throw InputError("--spacing", "",
                         formatted("%g m has no receiver in the room at the height of %g m; "
                                   "expected a smaller spacing or another height",
                                   spacing_m, height_m));
    return grid;
}

ReceiverGrid surface_grid(const Scene& scene, const RayScene& rays, const std::string& surface,
                          double offset_m, double spacing_m) {
    const Bounds bounds = bounds_of(rays);
    const auto belongs = triangles_of(scene, rays, surface);
    if (!belongs)
        throw InputError("--surface", "",
                         "the scene has no material and no object \"" + surface +
                             "\"; expected one of " + surface_names(scene));
    ReceiverGrid grid = cells_of(bounds, spacing_m);
    grid.place = formatted("%g m above ", offset_m) + surface;
    // Faces that overlap in one plane are up to 1 mm apart.
    constexpr float kOverlap_m = 2e-3F;
    std::vector<Candidate> candidates;
    for (std::size_t t = 0; t < belongs->size(); ++t) {
        if (!(*belongs)[t]) continue;
        const RayScene::Triangle& triangle = rays.triangles()[t];
        Bounds extent;
        extent.add(triangle.vertices);
        for_each_cell(grid, extent, [&](std::size_t cell) {
            const glm::vec2 middle = middle_of(grid, cell);
            const auto height = height_at(triangle, middle);
            if (!height) return;
            const Vec3 position(middle, *height + static_cast<float>(offset_m));
            if (rays.visible(Vec3(middle, *height + kOverlap_m), position))
                candidates.push_back({cell, position});
        });
    }
    std::sort(candidates.begin(), candidates.end());
    // Coincident faces, and a common edge of two triangles.
    candidates.erase(std::unique(candidates.begin(), candidates.end(),
                                 [](const Candidate& a, const Candidate& b) {
                                     return a.cell == b.cell &&
                                            b.position.z - a.position.z < kOverlap_m;
                                 }),
                     candidates.end());
    add_receivers(grid, scene, rays, bounds.diagonal_m(), candidates);
    if (grid.receivers.empty())
        throw InputError("--surface", "",
                         formatted("no point %g m above ", offset_m) + surface +
                             formatted(" is in the room and 0.1 m from all surfaces, at a spacing "
                                       "of %g m; expected another --offset or --spacing",
                                       spacing_m));
    for (const Pose& receiver : grid.receivers)
        grid.height_m += receiver.position.z / static_cast<float>(grid.receivers.size());
    return grid;
}

}  // namespace aula
