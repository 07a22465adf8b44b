#include "engine/waves/room_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "engine/base/bisection.h"
#include "engine/base/mix64.h"
#include "engine/waves/wall_damping.h"

namespace aula {

namespace {

constexpr double kPi = std::numbers::pi;

/// Cells in the shortest wavelength. At 5 the response of a box is 1.1 dB rms off, at 6 and above
/// 0.8 dB, where the damping's error remains.
constexpr double kCellsPerWavelength = 6.5;

/// Of the polynomials. The first one amplifies the lowest modes 450 times: at more, products of
/// columns that contain all modes lose the highest ones in single precision. Columns of another
/// room, and later ones, are nearly single modes; the square of that leaves 1 % of the lowest ones
/// in the highest.
constexpr int kFirstDegree = 12;
constexpr int kDegree = 24;  // of all but the first

/// The error of a frequency at which passes end: a tenth of that of the grid
/// (`test_waves "room_modes: a box*"`).
constexpr double kMaxError = 1e-4;

/// The same where the room changes, so that it is followed sooner: the error that the test
/// `test_waves "room_waves: after a small change*"` allows, up to the share of the highest wave
/// number above which the taper leaves less than a third of a mode.
constexpr double kMaxChangingError = 1e-3;
// Of the highest wave number.
constexpr double kChangingShare = 1 - kModeTaper / 3;

/// Passes from the modes of a room that differs, after which a search begins anew: more than three
/// show that it differs too much.
constexpr int kMaxWarmPasses = 4;

/// Passes at most, ten of a search that began anew: a bound of the time, where modes are nearly
/// equal to those that have no columns.
constexpr int kMaxPasses = 10 + kMaxWarmPasses;

/// More columns than modes: without them the highest modes converge slowly. A pass takes a time in
/// proportion to the square of their number.
constexpr double kSpareShare = 0.12;
constexpr double kSpareColumns = 10;  // in small rooms, of few modes

/// Squared wave number of the last column over the highest one that is wanted. By Weyl's law the
/// number of modes grows with its power 1.5: (1 + kSpareShare)^(2/3).
constexpr double kFirstLow = 1.08;

/// The filter begins this far above the highest squared wave number at least, so that it does not
/// damp modes that are wanted.
constexpr double kLeastLow = 1.02;

/// Of the wave number of the last column, the least exact one: from here on modes are unknown.
constexpr double kKnownShare = 0.98;

/// A squared norm, of 1, below which a column depends on the others in single precision.
constexpr double kDependent = 2e-5;

/// Above it the columns are so independent that one factor makes them orthonormal.
constexpr double kIndependent = 0.05;

/// Below this squared wave number in 1/m2, 0.5 Hz, a mode is the constant pressure: a room whose
/// first mode is lower is 300 m long, and single precision leaves less than 1e-6 of the highest
/// one.
constexpr double kConstant = 1e-4;

/// In place of 0, the squared norm of a column without values; its inverse root is a float.
constexpr double kNoSquare{std::numeric_limits<float>::min()};

/// Share of noise in the first columns, which finds modes that no product of cosines contains.
constexpr float kNoise = 0.3F;

/// The lower triangle of Cholesky's factor of a matrix, whose columns are taken by descending
/// remainder until it is below a limit. The order tells them.
struct PivotedFactor {
    std::vector<std::size_t> order;  ///< [row] column of the matrix
    DenseMatrix lower;

    /// The least remainder that was taken.
    double least() const {
        const double last = lower.at(order.size() - 1, order.size() - 1);
        return last * last;
    }
};

PivotedFactor factored(const DenseMatrix& matrix, double least) {
    const std::size_t n = matrix.rows;
    PivotedFactor result;
    result.lower = DenseMatrix(n, n);
    DenseMatrix& lower = result.lower;
    std::vector<std::size_t> order(n);
    std::vector<double> rest(n);
    for (std::size_t i = 0; i < n; ++i) {
        order[i] = i;
        rest[i] = matrix.at(i, i);
    }
    std::size_t rank = 0;
    for (; rank < n; ++rank) {
        const auto best = static_cast<std::size_t>(
            std::max_element(rest.begin() + static_cast<std::ptrdiff_t>(rank), rest.end()) -
            rest.begin());
        if (!(rest[best] > least)) break;
        std::swap(order[rank], order[best]);
        std::swap(rest[rank], rest[best]);
        for (std::size_t k = 0; k < rank; ++k) std::swap(lower.at(rank, k), lower.at(best, k));
        const double pivot = std::sqrt(rest[rank]);
        lower.at(rank, rank) = pivot;
        for (std::size_t i = rank + 1; i < n; ++i) {
            double sum = matrix.at(order[i], order[rank]);
            for (std::size_t k = 0; k < rank; ++k) sum -= lower.at(i, k) * lower.at(rank, k);
            lower.at(i, rank) = sum / pivot;
            rest[i] -= lower.at(i, rank) * lower.at(i, rank);
        }
    }
    order.resize(rank);
    result.order = std::move(order);
    return result;
}

/// The first rows and columns.
DenseMatrix corner(const DenseMatrix& m, std::size_t count) {
    DenseMatrix result(count, count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < count; ++j) result.at(i, j) = m.at(i, j);
    }
    return result;
}

/// The transposed inverse of the factor, so that columns times it are orthonormal: one row for each
/// column of the matrix.
DenseMatrix orthonormalizer(const PivotedFactor& factor) {
    const std::size_t rank = factor.order.size();
    const DenseMatrix inverse = inverse_of_lower(corner(factor.lower, rank));
    DenseMatrix result(factor.lower.rows, rank);
    for (std::size_t i = 0; i < rank; ++i) {
        for (std::size_t j = i; j < rank; ++j) {
            result.at(factor.order[i], j) = inverse.at(j, i);
        }
    }
    return result;
}

/// Uniform in [-1, 1), the same for the same numbers.
float noise(std::size_t cell, std::size_t column, std::uint64_t round) {
    const std::uint64_t bits = mix64(mix64(cell + 1) ^ (column << 8 | round));
    return static_cast<float>(bits >> 40) * 0x1p-23F - 1;
}

/// Products of cosines over the bounding box, the lowest first, with noise.
ModeColumns first_columns(const WaveGrid& grid, std::size_t blocks) {
    Vec3 low(std::numeric_limits<float>::infinity());
    Vec3 high = -low;
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        low = glm::min(low, grid.centre_m[i] - grid.size_m[i] / 2.0F);
        high = glm::max(high, grid.centre_m[i] + grid.size_m[i] / 2.0F);
    }
    struct Product {
        float wave_number2 = 0;
        std::array<std::size_t, 3> order{};
    };
    const Vec3 extent = high - low;
    const std::size_t columns = blocks * ModeColumns::kBlock;
    std::vector<Product> products;
    // Orders (a + 1)(b + 1)(c + 1) > columns are preceded by as many lower products.
    for (std::size_t a = 0; a < columns; ++a) {
        for (std::size_t b = 0; (a + 1) * (b + 1) <= columns; ++b) {
            for (std::size_t c = 0; (a + 1) * (b + 1) * (c + 1) <= columns; ++c) {
                const Vec3 k = Vec3(a, b, c) / extent;
                products.push_back({glm::dot(k, k), {a, b, c}});
            }
        }
    }
    std::stable_sort(products.begin(), products.end(), [](const Product& a, const Product& b) {
        return a.wave_number2 < b.wave_number2;
    });
    products.resize(std::min(products.size(), columns));
    std::array<std::size_t, 3> highest{};
    for (const Product& product : products)
        for (std::size_t axis = 0; axis < 3; ++axis)
            highest[axis] = std::max(highest[axis], product.order[axis]);
    ModeColumns result(grid.cells(), blocks);
    std::array<std::vector<float>, 3> cosines;  // [order] along each axis, at a cell
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        const Vec3 at = (grid.centre_m[i] - low) / extent;
        const float scale = std::sqrt(grid.volume_m3[i]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cosines[axis].clear();
            for (std::size_t order = 0; order <= highest[axis]; ++order)
                cosines[axis].push_back(
                    static_cast<float>(std::cos(std::numbers::pi * static_cast<double>(order) *
                                                double{at[static_cast<int>(axis)]})));
        }
        for (std::size_t j = 0; j < columns; ++j) {
            float value = kNoise * noise(i, j, 0);
            if (j < products.size()) {
                const auto& order = products[j].order;
                value += cosines[0][order[0]] * cosines[1][order[1]] * cosines[2][order[2]];
            }
            result.at(i, j) = scale * value;
        }
    }
    return result;
}

/// The shapes of a room that differs little. A cell without air there gets the mean of the cells
/// beside it, or noise of the same level. A step at a leaf that has moved would add all high modes.
ModeColumns first_columns(const WaveGrid& grid, std::size_t blocks, const NearModes& near) {
    ModeColumns result(grid.cells(), blocks);
    const std::size_t known = std::min(result.columns(), near.shapes.columns());
    const auto level = static_cast<float>(1 / std::sqrt(grid.total_volume_m3()));
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        std::vector<std::uint32_t> from;
        if (near.cells[i]) {
            from.push_back(*near.cells[i]);
        } else {
            for (std::uint32_t k = grid.first_link[i]; k < grid.first_link[i + 1]; ++k)
                if (const auto& beside = near.cells[grid.links[k].cell]) from.push_back(*beside);
        }
        const float scale = std::sqrt(grid.volume_m3[i]);
        for (std::size_t j = 0; j < result.columns(); ++j) {
            float value = 0;
            if (j < known)
                for (const std::uint32_t cell : from) value += near.shapes.at(cell, j);
            const bool is_known = j < known && !from.empty();
            result.at(i, j) = scale * (is_known ? value / static_cast<float>(from.size())
                                                : level * noise(i, j, 0));
        }
    }
    return result;
}

/// The columns divided by their norms.
void normalize(ModeColumns& columns, WorkerPool& pool) {
    pool.run(columns.blocks(), [&](std::size_t b) {
        std::array<double, ModeColumns::kBlock> sums{};
        float* values = columns.block(b);
        for (std::size_t i = 0; i < columns.cells() * ModeColumns::kBlock; ++i) {
            sums[i % ModeColumns::kBlock] += double{values[i]} * double{values[i]};
        }
        std::array<float, ModeColumns::kBlock> scale{};
        for (std::size_t k = 0; k < scale.size(); ++k) {
            scale[k] = static_cast<float>(1 / std::sqrt(std::max(sums[k], kNoSquare)));
        }
        for (std::size_t i = 0; i < columns.cells() * ModeColumns::kBlock; ++i) {
            values[i] *= scale[i % ModeColumns::kBlock];
        }
    });
}

/// Rayleigh-Ritz: the columns become approximate eigenvectors; returns their eigenvalues,
/// ascending. Columns that depend on others are replaced by noise and have no eigenvalue.
std::vector<double> project(const WaveOperator& op, ModeColumns& columns, std::uint64_t round,
                            WorkerPool& pool) {
    normalize(columns, pool);
    PivotedFactor factor = factored(columns.products(columns, pool), kDependent);
    const std::size_t rank = factor.order.size();
    if (rank < columns.columns() || factor.least() < kIndependent) {
        columns = columns.times(orthonormalizer(factor), pool);
        // Orthonormal up to the rounding of dependent columns, which a second factor removes.
        factor = factored(corner(columns.products(columns, pool), rank), kDependent);
    }
    const DenseMatrix orthonormal = orthonormalizer(factor);
    const DenseMatrix energy = corner(columns.products(columns.applied(op, pool), pool), rank);
    const SymmetricEigen eigen =
        symmetric_eigen(product_transposed(orthonormal, product(energy, orthonormal)));
    columns = columns.times(product(orthonormal, eigen.vectors), pool);
    for (std::size_t j = eigen.values.size(); j < columns.columns(); ++j) {
        for (std::size_t i = 0; i < columns.cells(); ++i) columns.at(i, j) = noise(i, j, round);
    }
    return eigen.values;
}

/// The largest estimated relative error of the frequencies below a squared wave number. The error
/// of an eigenvalue is the square of its residual over its distance to the eigenvalues outside the
/// subspace.
double frequency_error(const WaveOperator& op, const ModeColumns& columns,
                       const std::vector<double>& eigenvalues, double highest2, WorkerPool& pool) {
    const ModeColumns applied = columns.applied(op, pool);
    std::vector<double> error(columns.blocks());
    pool.run(columns.blocks(), [&](std::size_t b) {
        for (std::size_t k = 0; k < ModeColumns::kBlock; ++k) {
            const std::size_t j = b * ModeColumns::kBlock + k;
            if (j >= eigenvalues.size() || eigenvalues[j] > highest2) return;
            if (eigenvalues[j] < kConstant) continue;
            double sum = 0;
            for (std::size_t i = 0; i < columns.cells(); ++i) {
                const double r =
                    double{applied.at(i, j)} - eigenvalues[j] * double{columns.at(i, j)};
                sum += r * r;
            }
            const double distance = std::max(eigenvalues.back() - eigenvalues[j], kConstant);
            error[b] = std::max(error[b], sum / (2 * eigenvalues[j] * distance));
        }
    });
    return *std::max_element(error.begin(), error.end());
}

/// The eigenvalues without the dispersion of the grid. The second difference D of a wave number k
/// along an axis is 4 sin^2(k h / 2) / h^2, so that k^2 = D + h^2 D^2 / 12 + h^4 D^3 / 90 + ...
/// Cells that a wall cuts do not count.
void correct_dispersion(const WaveGrid& grid, const ModeColumns& columns,
                        std::vector<double>& eigenvalues, WorkerPool& pool) {
    std::vector<double> sums(columns.columns());
    std::vector<double> energies(columns.columns());
    for (int axis = 0; axis < 3; ++axis) {
        const WaveOperator op(grid, axis);
        const ModeColumns once = columns.applied(op, pool);
        const ModeColumns twice = once.applied(op, pool);
        pool.run(columns.blocks(), [&](std::size_t b) {
            for (std::size_t i = 0; i < grid.cells(); ++i) {
                if (!grid.is_whole[i]) continue;
                const double h2 = double{grid.size_m[i][axis]} * double{grid.size_m[i][axis]};
                for (std::size_t k = 0; k < ModeColumns::kBlock; ++k) {
                    const std::size_t j = b * ModeColumns::kBlock + k;
                    const double d{once.at(i, j)};
                    sums[j] += h2 / 12 * d * d + h2 * h2 / 90 * d * double{twice.at(i, j)};
                    if (axis == 0)
                        energies[j] += double{columns.at(i, j)} * double{columns.at(i, j)};
                }
            }
        });
    }
    for (std::size_t j = 0; j < eigenvalues.size(); ++j) {
        if (energies[j] > 0) eigenvalues[j] += sums[j] / energies[j];
    }
}

}  // namespace

double weyl_count(double wave_number, double volume_m3, double surface_m2) {
    const double k2 = wave_number * wave_number;
    return volume_m3 * k2 * wave_number / (6 * kPi * kPi) + surface_m2 * k2 / (16 * kPi);
}

double weyl_wave_number(double count, double volume_m3, double surface_m2) {
    const auto is_below = [&](double k) { return weyl_count(k, volume_m3, surface_m2) < count; };
    double high = 1;
    while (is_below(high)) high *= 2;
    return bisected(0, high, is_below);
}

double cell_for_wave_number_m(double wave_number) {
    return 2 * kPi / (kCellsPerWavelength * wave_number);
}

double wave_number_of_cell(double cell_m) { return 2 * kPi / (kCellsPerWavelength * cell_m); }

RoomModes find_room_modes(const WaveGrid& grid, double highest_wave_number, WorkerPool& pool,
                          const std::optional<NearModes>& near, const std::stop_token& stop) {
    RoomModes modes;
    modes.highest_wave_number = highest_wave_number;
    modes.expected_count = weyl_count(highest_wave_number, grid.total_volume_m3(), grid.wall_m2());
    const double wanted = modes.expected_count * (1 + kSpareShare) + kSpareColumns;
    const std::size_t blocks =
        std::min(static_cast<std::size_t>(wanted) / ModeColumns::kBlock + 1,
                 std::max<std::size_t>(1, grid.cells() / (2 * ModeColumns::kBlock)));
    const WaveOperator op(grid);
    const double highest2 = highest_wave_number * highest_wave_number;

    const double first_low = kFirstLow * highest2;
    bool is_warm = near.has_value();
    ModeColumns columns =
        is_warm ? first_columns(grid, blocks, *near) : first_columns(grid, blocks);
    bool is_mixed = !is_warm;  // each column contains all modes
    std::vector<double> eigenvalues;
    double low = first_low;
    for (modes.passes = 1;; ++modes.passes) {
        columns.filter(op, is_mixed ? kFirstDegree : kDegree, low, double{op.bound}, pool);
        eigenvalues = project(op, columns, static_cast<std::uint64_t>(modes.passes), pool);
        modes.error =
            frequency_error(op, columns, eigenvalues,
                            (is_warm ? kChangingShare * kChangingShare : 1) * highest2, pool);
        if (modes.error < (is_warm ? kMaxChangingError : kMaxError) || modes.passes == kMaxPasses ||
            stop.stop_requested())
            break;
        low = std::max(eigenvalues.back(), kLeastLow * highest2);
        is_mixed = false;
        if (is_warm && modes.passes == kMaxWarmPasses) {
            is_warm = false;
            columns = first_columns(grid, blocks);
            is_mixed = true;
            low = first_low;
        }
    }
    correct_dispersion(grid, columns, eigenvalues, pool);

    // Modes above the last column, which is the least exact, are unknown.
    const double last2 = *std::max_element(eigenvalues.begin(), eigenvalues.end());
    modes.highest_wave_number = std::min(highest_wave_number, kKnownShare * std::sqrt(last2));
    std::vector<std::size_t> order(columns.columns());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(eigenvalues.size()),
                     [&](std::size_t a, std::size_t b) { return eigenvalues[a] < eigenvalues[b]; });
    for (std::size_t j = 0; j < eigenvalues.size(); ++j) {
        const double k2 = eigenvalues[order[j]];
        if (k2 > modes.highest_wave_number * modes.highest_wave_number) break;
        modes.wave_number2.push_back(k2 < kConstant ? 0 : k2);
    }
    modes.shapes = ModeColumns(grid.cells(), blocks);
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        const float scale = 1 / std::sqrt(grid.volume_m3[i]);
        for (std::size_t j = 0; j < order.size(); ++j) {
            modes.shapes.at(i, j) = scale * columns.at(i, order[j]);
        }
    }
    return modes;
}

}  // namespace aula
