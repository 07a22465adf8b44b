#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/worker_pool.h"
#include "engine/waves/dense_eigen.h"
#include "engine/waves/wave_grid.h"

namespace aula {

/// The symmetric operator volume^-1/2 K volume^-1/2 of a grid, K from its conductances: a diagonal
/// and weights of the neighbours. Its eigenvalues are the squared wave numbers of the rigid room.
struct WaveOperator {
    explicit WaveOperator(const WaveGrid& grid);
    /// With the faces across one axis only.
    WaveOperator(const WaveGrid& grid, int axis);

    std::vector<std::uint32_t> first;  ///< [cell], and the number of neighbours
    std::vector<std::uint32_t> neighbour;
    std::vector<float> weight;
    std::vector<float> diagonal;  ///< [cell]
    float bound = 0;              ///< upper bound of the eigenvalues (Gershgorin)

    std::size_t cells() const { return diagonal.size(); }

 private:
    template <typename Counts>
    void add(const WaveGrid& grid, const Counts& counts);
};

/// Columns of numbers over the cells of a grid, in blocks of kBlock columns that are stored one
/// after another. Sums have a fixed order, so that results do not depend on the number of threads.
class ModeColumns {
 public:
    /// The lanes of single precision of the widest vector unit, 512 bits.
    static constexpr std::size_t kBlock = 16;

    ModeColumns(std::size_t cells, std::size_t blocks)
        : cells_(cells), blocks_(blocks), values_(cells * blocks * kBlock) {}

    std::size_t cells() const { return cells_; }
    std::size_t blocks() const { return blocks_; }
    std::size_t columns() const { return blocks_ * kBlock; }

    /// [cell][kBlock]
    float* block(std::size_t b) { return values_.data() + b * cells_ * kBlock; }
    const float* block(std::size_t b) const { return values_.data() + b * cells_ * kBlock; }
    float& at(std::size_t cell, std::size_t column) {
        return block(column / kBlock)[cell * kBlock + column % kBlock];
    }
    float at(std::size_t cell, std::size_t column) const {
        return block(column / kBlock)[cell * kBlock + column % kBlock];
    }

    /// Chebyshev's polynomial of an operator applied to each column: eigenvectors with eigenvalues
    /// in [low, high] are damped against those below. Scaled to 1 at the eigenvalue 0 (Zhou and
    /// Saad 2007).
    void filter(const WaveOperator& op, int degree, double low, double high, WorkerPool& pool);

    /// The operator applied to each column.
    ModeColumns applied(const WaveOperator& op, WorkerPool& pool) const;

    /// This times a matrix with one row per column; missing columns are 0.
    ModeColumns times(const DenseMatrix& matrix, WorkerPool& pool) const;

    /// The products of all columns with those of another, which must be a symmetric matrix.
    DenseMatrix products(const ModeColumns& other, WorkerPool& pool) const;

 private:
    std::size_t cells_;
    std::size_t blocks_;
    std::vector<float> values_;
};

}  // namespace aula
