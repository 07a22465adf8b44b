#include "engine/waves/dense_eigen.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace aula {

namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

Eigen::Map<const RowMajor> mapped(const DenseMatrix& m) {
    return {m.values.data(), index(m.rows), index(m.columns)};
}

}  // namespace

SymmetricEigen symmetric_eigen(const DenseMatrix& matrix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(mapped(matrix))};
    SymmetricEigen result;
    result.values.assign(solver.eigenvalues().begin(), solver.eigenvalues().end());
    result.vectors = DenseMatrix(matrix.rows, matrix.columns);
    Eigen::Map<RowMajor>(result.vectors.values.data(), index(matrix.rows), index(matrix.columns)) =
        solver.eigenvectors();
    return result;
}

std::vector<DampedPole> damped_poles(const std::vector<double>& stiffness,
                                     const DenseMatrix& damping) {
    // With W = sqrt(stiffness) the state (W a, s a) has the matrix [0 W; -W -D], which is normal
    // without damping, so that its eigenvectors are well conditioned.
    const Eigen::Index n = index(stiffness.size());
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
        state(i, n + i) = std::sqrt(stiffness[static_cast<std::size_t>(i)]);
        state(n + i, i) = -state(i, n + i);
    }
    state.bottomRightCorner(n, n) = -mapped(damping);
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(state);

    // A symmetric system has the same left and right eigenvectors x. Its response is the sum of
    // x x^T / (x^T (2 s + D) x) / (s - pole) (Tisseur and Meerbergen 2001).
    std::vector<DampedPole> poles;
    for (Eigen::Index i = 0; i < 2 * n; ++i) {
        const std::complex<double> s = solver.eigenvalues()(i);
        if (s.imag() < 0) continue;
        const Eigen::VectorXcd x = solver.eigenvectors().col(i).tail(n);
        // Without conjugation.
        const std::complex<double> norm =
            2.0 * s * (x.transpose() * x)(0) + (x.transpose() * (mapped(damping) * x))(0);
        const Eigen::VectorXcd shape = x / std::sqrt(norm);
        poles.push_back({s, {shape.begin(), shape.end()}});
    }
    return poles;
}

}  // namespace aula
