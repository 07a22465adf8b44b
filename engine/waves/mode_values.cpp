#include "engine/waves/mode_values.h"

#include <cmath>
#include <cstdint>

namespace aula {

namespace {

/// Of polynomials of third degree.
constexpr std::size_t kNodes = 4;

/// A walk from cell to cell along an axis, which turns round at a wall.
struct CellWalk {
    std::uint32_t cell = 0;
    std::size_t side = 0;  ///< of WaveGrid::Neighbours
    float at_m = 0;        ///< centre of the cell, or of its image behind a wall

    void step(const WaveGrid& grid, float sign) {
        const auto axis = static_cast<int>(side / 2);
        const std::uint32_t next = grid.across[cell][side];
        if (next == cell) {
            at_m += sign * grid.size_m[cell][axis];
            side ^= 1U;
        } else {
            at_m += sign * std::abs(grid.centre_m[next][axis] - grid.centre_m[cell][axis]);
            cell = next;
        }
    }
};

/// The cells of the nodes along an axis, from a cell, and the nodes' positions; the walks begin
/// `before` cells below it.
std::array<CellWalk, kNodes> nodes_along(const WaveGrid& grid, std::uint32_t cell, int axis,
                                         int before) {
    std::array<CellWalk, kNodes> nodes;
    const auto side = static_cast<std::size_t>(2 * axis);
    const auto home = static_cast<std::size_t>(before);
    nodes[home] = {cell, side, grid.centre_m[cell][axis]};
    CellWalk walk = nodes[home];
    for (std::size_t k = home; k > 0; --k) {
        walk.step(grid, -1);
        nodes[k - 1] = walk;
    }
    walk = {cell, side + 1, grid.centre_m[cell][axis]};
    for (std::size_t k = home + 1; k < kNodes; ++k) {
        walk.step(grid, 1);
        nodes[k] = walk;
    }
    return nodes;
}

struct NodeWeights {
    std::array<double, kNodes> value{};
    std::array<double, kNodes> slope{};
};

/// Lagrange's weights at a position, and their derivatives.
NodeWeights lagrange(const std::array<CellWalk, kNodes>& nodes, double at) {
    NodeWeights weights;
    for (std::size_t i = 0; i < kNodes; ++i) {
        double value = 1;
        double slope = 0;
        for (std::size_t j = 0; j < kNodes; ++j) {
            if (j == i) continue;
            const double span = double{nodes[i].at_m} - double{nodes[j].at_m};
            const double factor = (at - double{nodes[j].at_m}) / span;
            slope = slope * factor + value / span;
            value *= factor;
        }
        weights.value[i] = value;
        weights.slope[i] = slope;
    }
    return weights;
}

}  // namespace

std::optional<ModeValues> modes_at(const RoomGrid& grid, const RoomModes& modes,
                                   const Vec3& place) {
    const std::optional<std::uint32_t> home = grid.cell_at(place);
    if (!home) return {};
    const WaveGrid& cells = grid.cells();
    const Vec3 at = grid.lines().to_grid(place);
    std::array<int, 3> before{};
    std::array<NodeWeights, 3> weights;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        // The place is between the two nodes in the middle.
        constexpr int kBelow = static_cast<int>(kNodes) / 2 - 1;
        before[a] = at[axis] < cells.centre_m[*home][axis] ? kBelow + 1 : kBelow;
        weights[a] = lagrange(nodes_along(cells, *home, axis, before[a]), double{at[axis]});
    }

    ModeValues values;
    values.place = place;
    values.pressure.resize(modes.count());
    std::vector<std::array<double, 3>> slope(modes.count());
    const auto rows = nodes_along(cells, *home, 0, before[0]);
    for (std::size_t i = 0; i < kNodes; ++i) {
        const auto columns = nodes_along(cells, rows[i].cell, 1, before[1]);
        for (std::size_t j = 0; j < kNodes; ++j) {
            const auto nodes = nodes_along(cells, columns[j].cell, 2, before[2]);
            for (std::size_t k = 0; k < kNodes; ++k) {
                const double x = weights[0].value[i];
                const double y = weights[1].value[j];
                const double z = weights[2].value[k];
                const std::array<double, 4> w{x * y * z, weights[0].slope[i] * y * z,
                                              x * weights[1].slope[j] * z,
                                              x * y * weights[2].slope[k]};
                for (std::size_t m = 0; m < modes.count(); ++m) {
                    const double p{modes.shapes.at(nodes[k].cell, m)};
                    values.pressure[m] += w[0] * p;
                    for (std::size_t a = 0; a < 3; ++a) slope[m][a] += w[a + 1] * p;
                }
            }
        }
    }
    values.slope.resize(modes.count());
    for (std::size_t m = 0; m < modes.count(); ++m) {
        const Vec3 world = grid.lines().to_world(Vec3(slope[m][0], slope[m][1], slope[m][2]));
        values.slope[m] = {double{world.x}, double{world.y}, double{world.z}};
    }
    return values;
}

}  // namespace aula
