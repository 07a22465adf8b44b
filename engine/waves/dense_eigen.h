#pragma once

#include <complex>
#include <cstddef>
#include <vector>

namespace aula {

/// A dense matrix of doubles, row by row.
struct DenseMatrix {
    DenseMatrix() = default;
    DenseMatrix(std::size_t rows_in, std::size_t columns_in)
        : rows(rows_in), columns(columns_in), values(rows_in * columns_in) {}

    double& at(std::size_t row, std::size_t column) { return values[row * columns + column]; }
    double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }

    std::size_t rows = 0;
    std::size_t columns = 0;
    std::vector<double> values;
};

DenseMatrix product(const DenseMatrix& a, const DenseMatrix& b);

/// The product of the first one's transpose with the other.
DenseMatrix product_transposed(const DenseMatrix& a, const DenseMatrix& b);

/// Of the lower triangle of a square matrix; 0 above it.
DenseMatrix inverse_of_lower(const DenseMatrix& matrix);

/// The eigenvalues of a symmetric matrix in ascending order, and orthonormal eigenvectors.
struct SymmetricEigen {
    std::vector<double> values;
    DenseMatrix vectors;  ///< one in each column
};

/// Of the symmetric matrix whose lower triangle is given.
SymmetricEigen symmetric_eigen(const DenseMatrix& matrix);

/// A pole of a damped system, and its residue: the response of a pair of places with the values a
/// and b of the undamped modes contains (a . shape) (b . shape) / (s - pole).
struct DampedPole {
    std::complex<double> pole;
    std::vector<std::complex<double>> shape;  ///< [undamped mode]
};

/// Modes from `first` on, below `last`.
struct ModeRange {
    std::size_t first = 0;
    std::size_t last = 0;
};

/// The poles of s^2 + s D + diag(stiffness), with the symmetric matrix D of damping and stiffness
/// above 0, ascending: those with an imaginary part above 0, of which the conjugates are poles as
/// well, and the real ones. D couples some adjacent modes; of the others its diagonal counts.
std::vector<DampedPole> damped_poles(const std::vector<double>& stiffness,
                                     const DenseMatrix& damping, const ModeRange& coupled);

}  // namespace aula
