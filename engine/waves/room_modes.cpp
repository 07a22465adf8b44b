#include "engine/waves/room_modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/base/mix64.h"

namespace aula {

namespace {

constexpr double kPi = std::numbers::pi;

/// Cells in the shortest wavelength. At 5 the response of a box is 1.1 dB rms off, at 6 and above
/// 0.8 dB, where the damping's error remains.
constexpr double kCellsPerWavelength = 6.5;

/// Above it the polynomial amplifies the lowest modes so much, 450 times, that products in single
/// precision lose the others.
constexpr int kDegree = 12;

/// Passes at most, and the error of a frequency at which they end: below that of the grid.
constexpr int kMaxPasses = 10;
constexpr double kMaxError = 1e-4;

/// More columns than modes: without them the highest modes converge slowly.
constexpr double kSpareShare = 0.12;
constexpr double kSpareColumns = 10;

/// A squared norm, of 1, below which a column depends on the others in single precision.
constexpr double kDependent = 2e-5;

/// Below this squared wave number in 1/m2, 0.5 Hz, a mode is the constant pressure.
constexpr double kConstant = 1e-4;

/// Share of noise in the first columns, which finds modes that no product of cosines contains.
constexpr float kNoise = 0.3F;

/// The lower triangle of Cholesky's factor of a matrix, whose columns are taken by descending
/// remainder until it is below a limit. The order tells them.
struct PivotedFactor {
    std::vector<std::size_t> order;  ///< [row] column of the matrix
    DenseMatrix lower;
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

/// The transposed inverse of the factor, so that columns times it are orthonormal: one row for each
/// column of the matrix.
DenseMatrix orthonormalizer(const PivotedFactor& factor, std::size_t rows) {
    const std::size_t rank = factor.order.size();
    DenseMatrix inverse(rank, rank);  // of the lower triangle
    for (std::size_t j = 0; j < rank; ++j) {
        inverse.at(j, j) = 1 / factor.lower.at(j, j);
        for (std::size_t i = j + 1; i < rank; ++i) {
            double sum = 0;
            for (std::size_t k = j; k < i; ++k) sum -= factor.lower.at(i, k) * inverse.at(k, j);
            inverse.at(i, j) = sum / factor.lower.at(i, i);
        }
    }
    DenseMatrix result(rows, rank);
    for (std::size_t i = 0; i < rank; ++i) {
        for (std::size_t j = i; j < rank; ++j) {
            result.at(factor.order[i], j) = inverse.at(j, i);
        }
    }
    return result;
}

DenseMatrix product(const DenseMatrix& a, const DenseMatrix& b) {
    DenseMatrix result(a.rows, b.columns);
    for (std::size_t i = 0; i < a.rows; ++i) {
        for (std::size_t k = 0; k < a.columns; ++k) {
            const double factor = a.at(i, k);
            if (factor == 0) continue;
            for (std::size_t j = 0; j < b.columns; ++j) result.at(i, j) += factor * b.at(k, j);
        }
    }
    return result;
}

DenseMatrix transposed(const DenseMatrix& m) {
    DenseMatrix result(m.columns, m.rows);
    for (std::size_t i = 0; i < m.rows; ++i) {
        for (std::size_t j = 0; j < m.columns; ++j) result.at(j, i) = m.at(i, j);
    }
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
        std::array<int, 3> order{};
    };
    const Vec3 extent = high - low;
    const std::size_t columns = blocks * ModeColumns::kBlock;
    const int most = static_cast<int>(columns);
    std::vector<Product> products;
    // Orders (a + 1)(b + 1)(c + 1) > columns are preceded by as many lower products.
    for (int a = 0; a < most; ++a) {
        for (int b = 0; (a + 1) * (b + 1) <= most; ++b) {
            for (int c = 0; (a + 1) * (b + 1) * (c + 1) <= most; ++c) {
                const Vec3 k = Vec3(a, b, c) / extent;
                products.push_back({glm::dot(k, k), {a, b, c}});
            }
        }
    }
    std::stable_sort(products.begin(), products.end(), [](const Product& a, const Product& b) {
        return a.wave_number2 < b.wave_number2;
    });
    ModeColumns result(grid.cells(), blocks);
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        const Vec3 at = (grid.centre_m[i] - low) / extent;
        const float scale = std::sqrt(grid.volume_m3[i]);
        for (std::size_t j = 0; j < columns; ++j) {
            float value = kNoise * noise(i, j, 0);
            if (j < products.size()) {
                float cosines = 1;
                for (int axis = 0; axis < 3; ++axis) {
                    const auto order =
                        static_cast<float>(products[j].order[static_cast<std::size_t>(axis)]);
                    cosines *= std::cos(std::numbers::pi_v<float> * order * at[axis]);
                }
                value += cosines;
            }
            result.at(i, j) = scale * value;
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
            scale[k] = static_cast<float>(1 / std::sqrt(std::max(sums[k], 1e-30)));
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
    const PivotedFactor factor = factored(columns.products(columns, pool), kDependent);
    const std::size_t rank = factor.order.size();
    columns = columns.times(orthonormalizer(factor, columns.columns()), pool);
    // Orthonormal up to the rounding of dependent columns, which a second factor removes.
    const DenseMatrix second =
        orthonormalizer(factored(corner(columns.products(columns, pool), rank), kDependent), rank);
    const DenseMatrix energy = corner(columns.products(columns.applied(op, pool), pool), rank);
    const SymmetricEigen eigen =
        symmetric_eigen(product(transposed(second), product(energy, second)));
    columns = columns.times(product(second, eigen.vectors), pool);
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
    double low = 0;
    double high = 1;
    while (weyl_count(high, volume_m3, surface_m2) < count) high *= 2;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (weyl_count(middle, volume_m3, surface_m2) < count ? low : high) = middle;
    }
    return high;
}

double cell_for_wave_number_m(double wave_number) {
    return 2 * kPi / (kCellsPerWavelength * wave_number);
}

double wave_number_of_cell(double cell_m) { return 2 * kPi / (kCellsPerWavelength * cell_m); }

RoomModes find_room_modes(const WaveGrid& grid, double highest_wave_number, WorkerPool& pool) {
    RoomModes modes;
    modes.highest_wave_number = highest_wave_number;
    modes.expected_count = weyl_count(highest_wave_number, grid.total_volume_m3(), grid.wall_m2());
    const double wanted = modes.expected_count * (1 + kSpareShare) + kSpareColumns;
    const std::size_t blocks =
        std::min(static_cast<std::size_t>(wanted) / ModeColumns::kBlock + 1,
                 std::max<std::size_t>(1, grid.cells() / (2 * ModeColumns::kBlock)));
    const WaveOperator op(grid);
    const double highest2 = highest_wave_number * highest_wave_number;

    ModeColumns columns = first_columns(grid, blocks);
    std::vector<double> eigenvalues;
    double low = 1.08 * highest2;  // about where the spare columns end
    for (modes.passes = 1;; ++modes.passes) {
        columns.filter(op, kDegree, low, double{op.bound}, pool);
        eigenvalues = project(op, columns, static_cast<std::uint64_t>(modes.passes), pool);
        modes.error = frequency_error(op, columns, eigenvalues, highest2, pool);
        if (modes.error < kMaxError || modes.passes == kMaxPasses) break;
        low = std::max(eigenvalues.back(), 1.02 * highest2);
    }
    correct_dispersion(grid, columns, eigenvalues, pool);

    // Modes above the last column, which is the least exact, are unknown.
    const double last2 = *std::max_element(eigenvalues.begin(), eigenvalues.end());
    modes.highest_wave_number = std::min(highest_wave_number, 0.98 * std::sqrt(last2));
    std::vector<std::size_t> order;
    for (std::size_t j = 0; j < eigenvalues.size(); ++j) {
        if (eigenvalues[j] <= modes.highest_wave_number * modes.highest_wave_number) {
            order.push_back(j);
        }
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return eigenvalues[a] < eigenvalues[b]; });
    for (const std::size_t j : order) {
        modes.wave_number2.push_back(eigenvalues[j] < kConstant ? 0 : eigenvalues[j]);
    }
    modes.shapes =
        ModeColumns(grid.cells(), (order.size() + ModeColumns::kBlock - 1) / ModeColumns::kBlock);
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        const float scale = 1 / std::sqrt(grid.volume_m3[i]);
        for (std::size_t j = 0; j < order.size(); ++j) {
            modes.shapes.at(i, j) = scale * columns.at(i, order[j]);
        }
    }
    return modes;
}

}  // namespace aula
