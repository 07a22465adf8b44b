#include "engine/waves/room_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <utility>

#include "engine/rays/room_survey.h"

namespace aula {

namespace {

constexpr std::uint32_t kPoints = GridPoints::kPoints;
constexpr std::uint32_t kPointsOfCell = GridPoints::kPointsOfCell;
constexpr std::uint32_t kPointsOfFace = GridPoints::kPointsOfFace;
constexpr std::uint32_t kNoCell = GridPoints::kNoPart;

/// Rays between two points that connect parts of cells, a twelfth of a face: narrower gaps are
/// defects of a mesh.
constexpr std::uint32_t kLeastRays = kPointsOfFace / 12;

/// Smaller parts are merged with a neighbour. A part of a share s of its cell has up to 1 / s times
/// the eigenvalues of a cell, and the filters of modes need a degree in proportion to their root.
constexpr std::uint32_t kLeastPoints = kPointsOfCell / 5;

/// Walks that find the extent of the room, and their segments. A choice: of 48,000 reflections five
/// are expected on a recess with 1e-4 of the surface.
constexpr int kWalks = 2000;
constexpr int kBounces = 24;  // segments of a walk

/// Up to this angle to an axis (18 degrees) the pressure at a wall follows from two cells. A
/// choice: there the slope of the pressure along the axis is a third of that along the wall.
constexpr float kAcross = 0.95F;

/// A wall is at the face of a cell if it is nearer than this, in widths of the cell: less than the
/// distance of the first point, from which rays find the wall, to the face.
constexpr float kAtFace = 0.05F;
static_assert(kAtFace * kPoints < 0.5F);

}  // namespace

/// What is needed while a grid is built.
struct RoomGrid::Builder {
    using Index = GridPoints::Index;

    struct Face {
        std::uint32_t low = 0;  ///< parts
        std::uint32_t high = 0;
        std::uint32_t rays = 0;
        std::uint8_t axis = 0;
    };

    RoomGrid& room;
    const RayScene& scene;
    const GridPoints& points;
    std::vector<Face> faces;
    std::vector<char> reached;          ///< [part]
    std::vector<std::uint32_t> merged;  ///< [part] the part that it belongs to

    Builder(RoomGrid& built, const RayScene& rays)
        : room(built), scene(rays), points(built.points_) {}

    /// The corner of a cell on the low (0) or high (1) planes.
    Vec3 corner(std::uint32_t cell, std::size_t side) const {
        const Index i = points.cell_index(cell);
        Vec3 result;
        for (int a = 0; a < 3; ++a)
            result[a] = room.lines_.planes(a)[i[static_cast<std::size_t>(a)] + side];
        return result;
    }
    Vec3 cell_size(std::uint32_t cell) const { return corner(cell, 1) - corner(cell, 0); }
    Vec3 cell_centre(std::uint32_t cell) const {
        return (corner(cell, 1) + corner(cell, 0)) / 2.0F;
    }
    void find_faces();
    void reach(std::span<const Vec3> places);
    void merge_small();
    void number_cells();
    void link_cells();
    void find_neighbours();
    void find_walls();
    void find_whole();
    void add_wall(std::size_t axis, const Index& at, bool on_low_side, float wall_m,
                  std::uint32_t triangle);
};

/// Counts the open connections between parts of adjacent cells.
void RoomGrid::Builder::find_faces() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = axis == 0 ? 1 : 0;
        const std::size_t c = axis == 2 ? 1 : 2;
        for (std::uint32_t cell = 0; cell < points.cell_count(); ++cell) {
            const Index at = points.cell_index(cell);
            if (at[axis] + 1 == points.cells()[axis]) continue;
            Index beyond = at;
            ++beyond[axis];
            const std::uint32_t next_cell = points.cell_at(beyond);
            if (!points.is_cut(cell) && !points.is_cut_after(cell, axis) &&
                !points.is_cut(next_cell)) {
                faces.push_back({points.first_part(cell), points.first_part(next_cell),
                                 kPointsOfFace, static_cast<std::uint8_t>(axis)});
                continue;
            }
            const std::size_t first = faces.size();
            Index i{};
            i[axis] = at[axis] * kPoints + kPoints - 1;
            for (std::uint32_t k = 0; k < kPointsOfFace; ++k) {
                i[b] = at[b] * kPoints + k % kPoints;
                i[c] = at[c] * kPoints + k / kPoints;
                if (points.is_blocked(axis, i)) continue;
                Index next = i;
                ++next[axis];
                const std::uint32_t low = points.part_at(i);
                const std::uint32_t high = points.part_at(next);
                if (low == GridPoints::kNoPart || high == GridPoints::kNoPart) continue;
                const auto known =
                    std::find_if(faces.begin() + static_cast<std::ptrdiff_t>(first), faces.end(),
                                 [&](const Face& f) { return f.low == low && f.high == high; });
                if (known != faces.end()) {
                    ++known->rays;
                } else {
                    faces.push_back({low, high, 1, static_cast<std::uint8_t>(axis)});
                }
            }
        }
    }
    std::erase_if(faces, [](const Face& f) { return f.rays < kLeastRays; });
}

/// Marks the parts that are connected with the places.
void RoomGrid::Builder::reach(std::span<const Vec3> places) {
    reached.assign(points.parts(), 0);
    std::vector<std::uint32_t> waiting;
    for (const Vec3& place : places) {
        const std::optional<std::uint32_t> part = room.cell_at(place);
        if (!part || reached[*part] != 0) continue;
        reached[*part] = 1;
        waiting.push_back(*part);
    }
    std::vector<std::vector<std::uint32_t>> next(points.parts());
    for (const Face& face : faces) {
        next[face.low].push_back(face.high);
        next[face.high].push_back(face.low);
    }
    while (!waiting.empty()) {
        const std::uint32_t part = waiting.back();
        waiting.pop_back();
        for (const std::uint32_t other : next[part]) {
            if (reached[other] != 0) continue;
            reached[other] = 1;
            waiting.push_back(other);
        }
    }
    std::erase_if(faces, [&](const Face& f) { return reached[f.low] == 0; });
}

/// Joins small parts to the neighbour with the largest common face.
void RoomGrid::Builder::merge_small() {
    merged.resize(points.parts());
    for (std::uint32_t i = 0; i < merged.size(); ++i) merged[i] = i;
    const auto root = [&](std::uint32_t i) {
        while (merged[i] != i) i = merged[i];
        return i;
    };
    std::vector<std::vector<std::uint32_t>> of(points.parts());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        of[faces[f].low].push_back(f);
        of[faces[f].high].push_back(f);
    }
    std::vector<std::uint32_t> total(points.parts());
    for (std::uint32_t i = 0; i < points.parts(); ++i) total[i] = points.size(i);
    for (std::uint32_t part = 0; part < merged.size(); ++part) {
        if (reached[part] == 0 || points.size(part) >= kLeastPoints ||
            total[root(part)] >= kLeastPoints) {
            continue;
        }
        std::uint32_t best = kNoCell;
        std::uint32_t most = 0;
        for (const std::uint32_t f : of[part]) {
            const std::uint32_t other = root(faces[f].low == part ? faces[f].high : faces[f].low);
            if (other == root(part) || faces[f].rays <= most) continue;
            most = faces[f].rays;
            best = other;
        }
        if (best == kNoCell) continue;
        const std::uint32_t from = root(part);
        // The larger one gives the centre.
        const bool gives = total[best] >= total[from];
        merged[gives ? from : best] = gives ? best : from;
        total[gives ? best : from] = total[best] + total[from];
    }
    for (std::uint32_t i = 0; i < merged.size(); ++i) merged[i] = root(i);
}

void RoomGrid::Builder::number_cells() {
    WaveGrid& grid = room.grid_;
    room.cell_of_.assign(points.parts(), kNoCell);
    for (std::uint32_t part = 0; part < points.parts(); ++part) {
        if (reached[part] == 0 || merged[part] != part) continue;
        room.cell_of_[part] = static_cast<std::uint32_t>(grid.cells());
        grid.volume_m3.push_back(0);
        grid.centre_m.push_back(cell_centre(points.cell_of(part)));
        grid.size_m.push_back(cell_size(points.cell_of(part)));
        grid.is_whole.push_back(points.size(part) == kPointsOfCell ? 1 : 0);
    }
    for (std::uint32_t part = 0; part < points.parts(); ++part) {
        if (reached[part] == 0) continue;
        const std::uint32_t cell = room.cell_of_[merged[part]];
        room.cell_of_[part] = cell;
        if (merged[part] != part) grid.is_whole[cell] = 0;
        const Vec3 extent = cell_size(points.cell_of(part));
        grid.volume_m3[cell] += extent.x * extent.y * extent.z *
                                static_cast<float>(points.size(part)) /
                                static_cast<float>(kPointsOfCell);
    }
}

void RoomGrid::Builder::link_cells() {
    WaveGrid& grid = room.grid_;
    struct Pair {
        std::uint32_t from = 0;
        WaveGrid::Link link;
    };
    std::vector<Pair> pairs;
    for (const Face& face : faces) {
        const std::uint32_t low = room.cell_of_[face.low];
        const std::uint32_t high = room.cell_of_[face.high];
        if (low == high) continue;
        const int axis = face.axis;
        const Vec3 below = cell_size(points.cell_of(face.low));
        const Vec3 above = cell_size(points.cell_of(face.high));
        const float area_m2 = below[(axis + 1) % 3] * below[(axis + 2) % 3] *
                              static_cast<float>(face.rays) / static_cast<float>(kPointsOfFace);
        const float conductance_m = area_m2 / ((below[axis] + above[axis]) / 2);
        pairs.push_back({low, {high, conductance_m, face.axis}});
        pairs.push_back({high, {low, conductance_m, face.axis}});
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
        return std::pair(a.from, a.link.cell) < std::pair(b.from, b.link.cell);
    });
    grid.first_link.assign(grid.cells() + 1, 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        ++grid.first_link[pairs[i].from + 1];
        grid.links.push_back(pairs[i].link);
    }
    for (std::size_t i = 0; i < grid.cells(); ++i) grid.first_link[i + 1] += grid.first_link[i];
}

/// The neighbours through faces that are at least half open.
void RoomGrid::Builder::find_neighbours() {
    WaveGrid& grid = room.grid_;
    grid.across.resize(grid.cells());
    for (std::uint32_t i = 0; i < grid.cells(); ++i) {
        grid.across[i].fill(i);
        std::array<float, 6> most{};
        for (std::uint32_t k = grid.first_link[i]; k < grid.first_link[i + 1]; ++k) {
            const WaveGrid::Link& link = grid.links[k];
            const int axis = link.axis;
            const float step = grid.centre_m[link.cell][axis] - grid.centre_m[i][axis];
            const float face_m = grid.size_m[i][(axis + 1) % 3] * grid.size_m[i][(axis + 2) % 3] /
                                 grid.size_m[i][axis];
            const std::size_t side = 2 * link.axis + (step > 0 ? 1 : 0);
            if (step == 0 || link.conductance_m < face_m / 2 || link.conductance_m <= most[side]) {
                continue;
            }
            most[side] = link.conductance_m;
            grid.across[i][side] = link.cell;
        }
    }
}

/// Adds the wall that a connection from a point meets, of the area that belongs to the connection.
void RoomGrid::Builder::add_wall(std::size_t axis, const Index& at, bool on_low_side, float wall_m,
                                 std::uint32_t triangle) {
    const std::uint32_t part = points.part_at(at);
    if (part == GridPoints::kNoPart || room.cell_of_[part] == kNoCell) return;
    WaveGrid& grid = room.grid_;
    const auto a = static_cast<int>(axis);
    WaveGrid::WallPiece piece;
    piece.cell = room.cell_of_[part];
    piece.inner = grid.across[piece.cell][2 * axis + (on_low_side ? 0 : 1)];
    piece.material =
        triangle == kNoTriangle ? WaveGrid::kOpening : scene.triangle(triangle).material;
    const float cosine =
        triangle == kNoTriangle
            ? 1.0F
            : std::abs(glm::dot(scene.triangle(triangle).normal, room.lines_.axes()[a]));
    const Vec3 extent = cell_size(points.cell_of(part));
    // The sum of cosine * (area seen along an axis) over the axes is the area of a plane.
    piece.area_m2 =
        cosine * extent[(a + 1) % 3] * extent[(a + 2) % 3] / static_cast<float>(kPointsOfFace);
    if (piece.inner == piece.cell || cosine < kAcross) {
        piece.inner = piece.cell;
    } else {
        // At a rigid wall the pressure is p0 + q x^2 at the distance x.
        const float near_m = std::clamp(std::abs(wall_m - grid.centre_m[piece.cell][a]), 0.0F,
                                        grid.size_m[piece.cell][a]);
        const float far_m =
            near_m + std::abs(grid.centre_m[piece.inner][a] - grid.centre_m[piece.cell][a]);
        piece.beyond = near_m * near_m / (far_m * far_m - near_m * near_m);
    }
    grid.walls.push_back(piece);
}

void RoomGrid::Builder::find_walls() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t lines = points.lines_along(axis);
        std::vector<char> closed(std::size_t{2} * lines);
        for (const GridCrossing& crossing : points.crossings(axis)) {
            if (crossing.high_point > 0) {
                add_wall(axis, points.on_line(axis, crossing.line, crossing.high_point - 1), true,
                         crossing.first_m, crossing.first_triangle);
            } else {
                closed[2 * std::size_t{crossing.line}] = 1;
            }
            if (crossing.high_point < points.points()[axis]) {
                add_wall(axis, points.on_line(axis, crossing.line, crossing.high_point), false,
                         crossing.last_m, crossing.last_triangle);
            } else {
                closed[2 * std::size_t{crossing.line} + 1] = 1;
            }
        }
        const std::vector<float>& planes = room.lines_.planes(static_cast<int>(axis));
        for (std::uint32_t line = 0; line < lines; ++line) {
            if (closed[2 * std::size_t{line}] == 0) {
                add_wall(axis, points.on_line(axis, line, 0), false, planes.front(), kNoTriangle);
            }
            if (closed[2 * std::size_t{line} + 1] == 0) {
                add_wall(axis, points.on_line(axis, line, points.points()[axis] - 1), true,
                         planes.back(), kNoTriangle);
            }
        }
    }
    // One piece for each cell, side and material.
    std::vector<WaveGrid::WallPiece>& walls = room.grid_.walls;
    const auto key = [](const WaveGrid::WallPiece& w) {
        return std::tuple(w.cell, w.inner, w.material);
    };
    std::stable_sort(walls.begin(), walls.end(),
                     [&](const auto& a, const auto& b) { return key(a) < key(b); });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < walls.size(); ++i) {
        if (kept > 0 && key(walls[kept - 1]) == key(walls[i])) {
            WaveGrid::WallPiece& sum = walls[kept - 1];
            const float area_m2 = sum.area_m2 + walls[i].area_m2;
            if (area_m2 > 0) {
                sum.beyond += (walls[i].beyond - sum.beyond) * walls[i].area_m2 / area_m2;
            }
            sum.area_m2 = area_m2;
        } else {
            walls[kept++] = walls[i];
        }
    }
    walls.resize(kept);
}

/// Cells with a wall within them, or with a face that is open in part, are not whole.
void RoomGrid::Builder::find_whole() {
    WaveGrid& grid = room.grid_;
    for (const Face& face : faces) {
        if (face.rays == kPointsOfFace) continue;
        grid.is_whole[room.cell_of_[face.low]] = 0;
        grid.is_whole[room.cell_of_[face.high]] = 0;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<int>(axis);
        const auto check = [&](const Index& at, float wall_m) {
            const std::uint32_t part = points.part_at(at);
            if (part == GridPoints::kNoPart || room.cell_of_[part] == kNoCell) return;
            const std::uint32_t cell = room.cell_of_[part];
            const float off =
                std::abs(wall_m - grid.centre_m[cell][a]) / grid.size_m[cell][a] - 0.5F;
            if (std::abs(off) > kAtFace) grid.is_whole[cell] = 0;
        };
        for (const GridCrossing& crossing : points.crossings(axis)) {
            if (crossing.high_point > 0) {
                check(points.on_line(axis, crossing.line, crossing.high_point - 1),
                      crossing.first_m);
            }
            if (crossing.high_point < points.points()[axis]) {
                check(points.on_line(axis, crossing.line, crossing.high_point), crossing.last_m);
            }
        }
    }
}

std::vector<Vec3> room_extent(const RayScene& scene, std::span<const Vec3> places) {
    std::vector<Vec3> points(places.begin(), places.end());
    RandomWalks walks;
    walks.paths = kWalks;
    walks.bounces = kBounces;
    walks.through_moving = false;
    trace_random_walks(scene, places, walks, [&](float, const Ray& ray, const Hit& hit) {
        if (hit.any()) points.push_back(ray.origin + ray.direction * hit.distance_m);
    });
    return points;
}

RoomGrid::RoomGrid(std::shared_ptr<const RayScene> scene, std::span<const Vec3> extent,
                   std::span<const Vec3> places, float cell_m)
    : scene_(std::move(scene)), lines_(*scene_, extent, cell_m), points_(*scene_, lines_) {
    Builder builder(*this, *scene_);
    builder.find_faces();
    // Each part is a cell until the cells are numbered.
    cell_of_.resize(points_.parts());
    for (std::uint32_t i = 0; i < cell_of_.size(); ++i) cell_of_[i] = i;
    builder.reach(places);
    builder.merge_small();
    builder.number_cells();
    builder.link_cells();
    builder.find_neighbours();
    builder.find_walls();
    builder.find_whole();
    points_.shrink();
}

std::optional<GridPoints::Index> RoomGrid::nearest_point(const Vec3& place) const {
    const Vec3 at = lines_.to_grid(place);
    GridPoints::Index nearest{};
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float>& planes = lines_.planes(axis);
        const auto above = std::upper_bound(planes.begin(), planes.end(), at[axis]);
        if (above == planes.begin() || above == planes.end()) return {};
        const float share = (at[axis] - above[-1]) / (*above - above[-1]);
        nearest[static_cast<std::size_t>(axis)] =
            static_cast<std::uint32_t>(above - planes.begin() - 1) * kPoints +
            std::min(static_cast<std::uint32_t>(share * kPoints), kPoints - 1);
    }
    return nearest;
}

std::optional<std::uint32_t> RoomGrid::cell_of(const GridPoints::Index& point) const {
    const std::uint32_t part = points_.part_at(point);
    if (part == GridPoints::kNoPart || cell_of_[part] == kNoCell) return {};
    return cell_of_[part];
}

std::vector<std::optional<std::uint32_t>> RoomGrid::cells_of(const RoomGrid& other) const {
    std::vector<std::optional<std::uint32_t>> result(grid_.cells());
    std::vector<char> is_done(grid_.cells());
    for (std::uint32_t c = 0; c < points_.cell_count(); ++c) {
        const GridPoints::Index corner = points_.cell_index(c);
        // From the middle point on: of a cell that no wall divides one point suffices.
        constexpr std::uint32_t kMiddle = ((kPoints + 1) * kPoints + 1) * kPoints / 2;
        std::uint32_t parts = points_.first_part(c + 1) - points_.first_part(c);
        for (std::uint32_t k = 0; k < kPointsOfCell && parts > 0; ++k) {
            const std::uint32_t at = (kMiddle + k) % kPointsOfCell;
            const GridPoints::Index point{corner[0] * kPoints + at % kPoints,
                                          corner[1] * kPoints + at / kPoints % kPoints,
                                          corner[2] * kPoints + at / kPointsOfFace};
            const std::optional<std::uint32_t> cell = cell_of(point);
            if (!cell || is_done[*cell] != 0) continue;
            const Vec3 position = points_.position(point);
            const Vec3 from_centre = glm::abs(position - grid_.centre_m[*cell]);
            // A small part that was merged with a cell beside it.
            if (glm::any(glm::greaterThan(from_centre, grid_.size_m[*cell] * 0.5F))) continue;
            const auto nearest = other.nearest_point(lines_.to_world(position));
            if (nearest) result[*cell] = other.cell_of(*nearest);
            is_done[*cell] = 1;
            --parts;
        }
    }
    return result;
}

std::optional<std::uint32_t> RoomGrid::cell_at(const Vec3& place) const {
    const auto nearest = nearest_point(place);
    if (!nearest) return {};
    // The nearest point of the air, of the cube of 3 x 3 x 3 about the place, that no wall
    // separates from it.
    std::optional<std::uint32_t> found;
    int least = std::numeric_limits<int>::max();
    for (int k = 0; k < 3 * 3 * 3; ++k) {
        const std::array<int, 3> step{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
        const int distance = step[0] * step[0] + step[1] * step[1] + step[2] * step[2];
        if (distance >= least) continue;
        GridPoints::Index p{};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int64_t i = std::int64_t{(*nearest)[a]} + step[a];
            inside = inside && i >= 0 && i < points_.points()[a];
            p[a] = static_cast<std::uint32_t>(i);
        }
        const std::optional<std::uint32_t> cell = inside ? cell_of(p) : std::nullopt;
        if (!cell || !scene_->visible(place, lines_.to_world(points_.position(p)))) continue;
        least = distance;
        found = cell;
    }
    return found;
}

std::size_t RoomGrid::memory_bytes() const {
    const std::size_t of_cell = sizeof(float) + 2 * sizeof(Vec3) + sizeof(WaveGrid::Neighbours);
    return points_.memory_bytes() + cell_of_.size() * sizeof cell_of_[0] + grid_.cells() * of_cell +
           grid_.links.size() * sizeof grid_.links[0] + grid_.walls.size() * sizeof grid_.walls[0];
}

}  // namespace aula
