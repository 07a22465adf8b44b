#include "apps/documents/receiver_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <set>

#include "apps/session/base/formatted.h"
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

Vec3 position_of(const ReceiverGrid& grid, std::size_t cell) {
    return {grid.x_m + static_cast<float>(cell % grid.columns) * grid.spacing_m,
            grid.y_m + static_cast<float>(cell / grid.columns) * grid.spacing_m, grid.height_m};
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

/// [cell] 1 for the cells that are too near to a surface.
std::vector<char> cells_at_surfaces(const ReceiverGrid& grid, const RayScene& rays) {
    std::vector<char> near(grid.columns * grid.rows, 0);
    for (const RayScene::Triangle& triangle : rays.triangles()) {
        Bounds bounds;
        bounds.add(triangle.vertices);
        if (bounds.min.z - kGridClearance_m > grid.height_m ||
            bounds.max.z + kGridClearance_m < grid.height_m)
            continue;
        const auto columns =
            lines_near(bounds.min.x, bounds.max.x, grid.x_m, grid.spacing_m, grid.columns);
        const auto rows =
            lines_near(bounds.min.y, bounds.max.y, grid.y_m, grid.spacing_m, grid.rows);
        for (std::size_t row = rows[0]; row < rows[1]; ++row)
            for (std::size_t column = columns[0]; column < columns[1]; ++column) {
                const std::size_t cell = column + grid.columns * row;
                const Vec3 position = position_of(grid, cell);
                if (glm::distance(nearest_point(triangle, position), position) < kGridClearance_m)
                    near[cell] = 1;
            }
    }
    return near;
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
                       [&](int, const Ray& ray, const Hit& hit) {
                           if (!hit.any()) return;
                           const Vec3 middle = ray.origin + hit.distance_m / 2 * ray.direction;
                           const glm::ivec3 cube = glm::floor(middle / cube_m);
                           if (cubes.insert({cube.x, cube.y, cube.z}).second)
                               points.push_back(middle);
                       });
    return points;
}

/// The cells whose receivers are in the room.
std::vector<std::size_t> cells_in_room(const ReceiverGrid& grid, const Scene& scene,
                                       const RayScene& rays, float diagonal_m) {
    const std::vector<char> near = cells_at_surfaces(grid, rays);
    const std::vector<Vec3> inside = points_in_room(scene, rays, diagonal_m);
    std::vector<std::size_t> cells;
    for (std::size_t cell = 0; cell < near.size(); ++cell) {
        const Vec3 position = position_of(grid, cell);
        if (!near[cell] && std::any_of(inside.begin(), inside.end(), [&](const Vec3& point) {
                return rays.visible(position, point);
            }))
            cells.push_back(cell);
    }
    // Positions outside of a room may see points inside through an opening.
    if (escape_per_reflection(rays, inside, scene.simulation.seed) == 0) return cells;
    std::vector<Vec3> positions{inside[0]};
    for (const std::size_t cell : cells) positions.push_back(position_of(grid, cell));
    const std::vector<char> outside = outside_room(rays, positions, scene.simulation.seed);
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < cells.size(); ++i)
        if (!outside[i + 1]) kept.push_back(cells[i]);
    return kept;
}

/// The number of lines of a grid over `length_m`, at least 1.
double line_count(float length_m, double spacing_m) {
    // 1e-4: lengths that are a multiple of the spacing except for rounding.
    return std::max(1.0, std::floor(double{length_m} / spacing_m + 1e-4));
}

}  // namespace

ReceiverGrid receiver_grid(const Scene& scene, const RayScene& rays, double height_m,
                           double spacing_m) {
    if (rays.triangle_count() == 0)
        throw InputError("the scene has no geometry; expected a room to map");
    Bounds bounds;
    for (const RayScene::Triangle& triangle : rays.triangles()) bounds.add(triangle.vertices);
    if (!(bounds.min.z < bounds.max.z))
        throw InputError("the geometry has no height; expected a room to map");
    if (!(height_m > double{bounds.min.z} && height_m < double{bounds.max.z}))
        throw InputError("--height", "",
                         formatted("%g m is outside of the room; expected metres above %g and "
                                   "below %g",
                                   height_m, double{bounds.min.z}, double{bounds.max.z}));
    const Vec3 size = bounds.max - bounds.min;
    const double columns = line_count(size.x, spacing_m);
    const double rows = line_count(size.y, spacing_m);
    if (columns * rows > kMaxPoints)
        throw InputError("--spacing", "",
                         formatted("%g m makes %.3g points; expected a spacing with at most %g",
                                   spacing_m, columns * rows, kMaxPoints));
    ReceiverGrid grid;
    grid.height_m = static_cast<float>(height_m);
    grid.spacing_m = static_cast<float>(spacing_m);
    grid.columns = static_cast<std::size_t>(columns);
    grid.rows = static_cast<std::size_t>(rows);
    grid.x_m = (bounds.min.x + bounds.max.x - static_cast<float>((columns - 1) * spacing_m)) / 2;
    grid.y_m = (bounds.min.y + bounds.max.y - static_cast<float>((rows - 1) * spacing_m)) / 2;
    grid.cells = cells_in_room(grid, scene, rays, bounds.diagonal_m());
    if (grid.cells.empty())
        throw InputError("--spacing", "",
                         formatted("%g m has no receiver in the room at the height of %g m; "
                                   "expected a smaller spacing or another height",
                                   spacing_m, height_m));
    if (grid.cells.size() * scene.sources.size() > kMaxGridPairs)
        throw InputError(
            "--spacing", "",
            formatted("%g m makes %zu receivers for %zu sources; expected a larger "
                      "spacing, with at most %zu pairs",
                      spacing_m, grid.cells.size(), scene.sources.size(), kMaxGridPairs));
    for (const std::size_t cell : grid.cells)
        grid.receivers.push_back({.position = position_of(grid, cell)});
    return grid;
}

}  // namespace aula
