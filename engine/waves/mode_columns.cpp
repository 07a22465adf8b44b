#include "engine/waves/mode_columns.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "process/multiversion.h"

namespace aula {

namespace {

/// The columns of a block in one cell.
using Lanes = float __attribute__((vector_size(ModeColumns::kBlock * sizeof(float))));

[[gnu::always_inline]] inline Lanes loaded(const float* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

[[gnu::always_inline]] inline void store(const Lanes& lanes, float* to) {
    std::memcpy(to, &lanes, sizeof lanes);
}

/// Cells whose products are added in single precision, before they are added in double precision: a
/// block of them fills a level 1 cache of 32 KiB, and sums lose 2^-24 sqrt(512) = 1.4e-6.
constexpr std::size_t kRun = 512;
static_assert(kRun * ModeColumns::kBlock * sizeof(float) == 32 << 10);

/// Sums that are computed together: as many fill the sixteen registers of 256 bits.
constexpr std::size_t kTile = 8;
static_assert(ModeColumns::kBlock % kTile == 0);

/// y = a (A - c) x + b y
AULA_MULTIVERSION
void add_applied(const WaveOperator& op, const float* x, float* y, float a, float c, float b) {
    constexpr std::size_t kBlock = ModeColumns::kBlock;
    for (std::size_t i = 0; i < op.cells(); ++i) {
        Lanes sum = loaded(x + i * kBlock) * (op.diagonal[i] - c);
        for (std::uint32_t k = op.first[i]; k < op.first[i + 1]; ++k) {
            sum -= loaded(x + op.neighbour[k] * kBlock) * op.weight[k];
        }
        store(sum * a + loaded(y + i * kBlock) * b, y + i * kBlock);
    }
}

/// sums[k][l] += x[i][k] y[i][l] over cells i, for k < kTile.
AULA_MULTIVERSION
void add_products(const float* x, const float* y, std::size_t cells, float* sums) {
    Lanes sum[kTile] = {};
    for (std::size_t i = 0; i < cells; ++i) {
        const Lanes right = loaded(y + i * ModeColumns::kBlock);
        for (std::size_t k = 0; k < kTile; ++k) sum[k] += right * x[i * ModeColumns::kBlock + k];
    }
    std::memcpy(sums, sum, sizeof sum);
}

/// y[i] += sum over k < kBlock of x[i][k] rows[k], for cells in groups of kTile.
AULA_MULTIVERSION
void add_combined(const float* x, const float* rows, std::size_t cells, float* y) {
    constexpr std::size_t kBlock = ModeColumns::kBlock;
    std::size_t i = 0;
    for (; i + kTile <= cells; i += kTile) {
        Lanes sum[kTile];
        for (std::size_t j = 0; j < kTile; ++j) sum[j] = loaded(y + (i + j) * kBlock);
        for (std::size_t k = 0; k < kBlock; ++k) {
            const Lanes row = loaded(rows + k * kBlock);
            for (std::size_t j = 0; j < kTile; ++j) sum[j] += row * x[(i + j) * kBlock + k];
        }
        for (std::size_t j = 0; j < kTile; ++j) store(sum[j], y + (i + j) * kBlock);
    }
    for (; i < cells; ++i) {
        Lanes sum = loaded(y + i * kBlock);
        for (std::size_t k = 0; k < kBlock; ++k)
            sum += loaded(rows + k * kBlock) * x[i * kBlock + k];
        store(sum, y + i * kBlock);
    }
}

}  // namespace

template <typename Counts>
void WaveOperator::add(const WaveGrid& grid, const Counts& counts) {
    first.push_back(0);
    for (std::size_t i = 0; i < grid.cells(); ++i) {
        double sum = 0;
        double row = 0;
        for (std::uint32_t k = grid.first_link[i]; k < grid.first_link[i + 1]; ++k) {
            const WaveGrid::Link& link = grid.links[k];
            if (!counts(link)) continue;
            const double conductance_m{link.conductance_m};
            const double w = conductance_m / std::sqrt(double{grid.volume_m3[i]} *
                                                       double{grid.volume_m3[link.cell]});
            neighbour.push_back(link.cell);
            weight.push_back(static_cast<float>(w));
            sum += conductance_m / double{grid.volume_m3[i]};
            row += w;
        }
        first.push_back(static_cast<std::uint32_t>(neighbour.size()));
        diagonal.push_back(static_cast<float>(sum));
        bound = std::max(bound, static_cast<float>(sum + row));
    }
}

WaveOperator::WaveOperator(const WaveGrid& grid) {
    add(grid, [](const WaveGrid::Link&) { return true; });
}

WaveOperator::WaveOperator(const WaveGrid& grid, int axis) {
    add(grid, [axis](const WaveGrid::Link& link) { return link.axis == axis; });
}

void ModeColumns::filter(const WaveOperator& op, int degree, double low, double high,
                         WorkerPool& pool) {
    const double half = (high - low) / 2;
    const double centre = (high + low) / 2;
    pool.run(blocks_, [&](std::size_t b) {
        std::vector<float> other(cells_ * kBlock);
        float* present = block(b);
        float* next = other.data();
        const double sigma = -half / centre;
        double last = sigma;
        best_version<add_applied>(op, present, next, static_cast<float>(sigma / half),
                                  static_cast<float>(centre), 0.0F);
        std::swap(present, next);
        for (int k = 2; k <= degree; ++k) {
            const double factor = 1 / (2 / sigma - last);
            best_version<add_applied>(op, present, next, static_cast<float>(2 * factor / half),
                                      static_cast<float>(centre),
                                      static_cast<float>(-last * factor));
            std::swap(present, next);
            last = factor;
        }
        if (present != block(b)) std::copy_n(present, cells_ * kBlock, block(b));
    });
}

ModeColumns ModeColumns::applied(const WaveOperator& op, WorkerPool& pool) const {
    ModeColumns result(cells_, blocks_);
    pool.run(blocks_, [&](std::size_t b) {
        best_version<add_applied>(op, block(b), result.block(b), 1.0F, 0.0F, 0.0F);
    });
    return result;
}

ModeColumns ModeColumns::times(const DenseMatrix& matrix, WorkerPool& pool) const {
    ModeColumns result(cells_, blocks_);
    pool.run(blocks_, [&](std::size_t b) {
        std::vector<float> rows(columns() * kBlock);
        for (std::size_t k = 0; k < matrix.rows; ++k) {
            for (std::size_t l = 0; l < kBlock; ++l) {
                const std::size_t column = b * kBlock + l;
                if (column >= matrix.columns) continue;
                rows[k * kBlock + l] = static_cast<float>(matrix.at(k, column));
            }
        }
        for (std::size_t start = 0; start < cells_; start += kRun) {
            const std::size_t count = std::min(kRun, cells_ - start);
            for (std::size_t from = 0; from < blocks_; ++from) {
                best_version<add_combined>(block(from) + start * kBlock,
                                           rows.data() + from * kBlock * kBlock, count,
                                           result.block(b) + start * kBlock);
            }
        }
    });
    return result;
}

DenseMatrix ModeColumns::products(const ModeColumns& other, WorkerPool& pool) const {
    DenseMatrix result(columns(), columns());
    pool.run(blocks_ * blocks_, [&](std::size_t pair) {
        const std::size_t a = pair / blocks_;
        const std::size_t b = pair % blocks_;
        if (b < a) return;
        for (std::size_t k = 0; k < kBlock; k += kTile) {
            std::array<float, kTile * kBlock> sums;
            for (std::size_t start = 0; start < cells_; start += kRun) {
                best_version<add_products>(block(a) + start * kBlock + k,
                                           other.block(b) + start * kBlock,
                                           std::min(kRun, cells_ - start), sums.data());
                for (std::size_t i = 0; i < sums.size(); ++i) {
                    result.at(a * kBlock + k + i / kBlock, b * kBlock + i % kBlock) +=
                        double{sums[i]};
                }
            }
        }
    });
    for (std::size_t i = 0; i < columns(); ++i) {
        for (std::size_t j = 0; j < i; ++j) result.at(i, j) = result.at(j, i);
    }
    return result;
}

}  // namespace aula
