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

Eigen::Map<RowMajor> mapped(DenseMatrix& m) {
    return {m.values.data(), index(m.rows), index(m.columns)};
}

}  // namespace

DenseMatrix product(const DenseMatrix& a, const DenseMatrix& b) {
    DenseMatrix result(a.rows, b.columns);
    mapped(result).noalias() = mapped(a) * mapped(b);
    return result;
}

DenseMatrix product_transposed(const DenseMatrix& a, const DenseMatrix& b) {
    DenseMatrix result(a.columns, b.columns);
    mapped(result).noalias() = mapped(a).transpose() * mapped(b);
    return result;
}

DenseMatrix inverse_of_lower(const DenseMatrix& matrix) {
    DenseMatrix result(matrix.rows, matrix.rows);
    mapped(result).setIdentity();
    mapped(matrix).triangularView<Eigen::Lower>().solveInPlace(mapped(result));
    return result;
}

SymmetricEigen symmetric_eigen(const DenseMatrix& matrix) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver{Eigen::MatrixXd(mapped(matrix))};
    SymmetricEigen result;
    result.values.assign(solver.eigenvalues().begin(), solver.eigenvalues().end());
    result.vectors = DenseMatrix(matrix.rows, matrix.columns);
    mapped(result.vectors) = solver.eigenvectors();
    return result;
}

std::vector<DampedPole> damped_poles(const std::vector<double>& stiffness,
                                     const DenseMatrix& damping, const ModeRange& coupled) {
    // With W = sqrt(stiffness) the state (W a, s a) has the matrix [0 W; -W -D], which is normal
    // without damping, so that its eigenvectors are well conditioned. In single precision those of
    // modes of nearly the same frequency would mix.
    const Eigen::Index first = index(coupled.first);
    const Eigen::Index n = index(coupled.last) - first;
    const Eigen::MatrixXd coupling = mapped(damping).block(first, first, n, n);
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
        state(i, n + i) = std::sqrt(stiffness[static_cast<std::size_t>(first + i)]);
        state(n + i, i) = -state(i, n + i);
    }
    state.bottomRightCorner(n, n) = -coupling;
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(state);
    const Eigen::MatrixXcd vectors = solver.eigenvectors();

    // A symmetric system has the same left and right eigenvectors x. Its response is the sum of
    // x x^T / (x^T (2 s + D) x) / (s - pole) (Tisseur and Meerbergen 2001).
    std::vector<DampedPole> poles;
    const auto add = [&](std::complex<double> s, const Eigen::VectorXcd& x,
                         std::complex<double> norm, std::size_t start) {
        DampedPole& pole = poles.emplace_back();
        pole.pole = s;
        pole.shape.resize(stiffness.size());
        const std::complex<double> scale = 1.0 / std::sqrt(norm);
        for (Eigen::Index i = 0; i < x.size(); ++i)
            pole.shape[start + static_cast<std::size_t>(i)] = x(i) * scale;
    };
    for (Eigen::Index i = 0; i < 2 * n; ++i) {
        const std::complex<double> s = solver.eigenvalues()(i);
        if (s.imag() < 0) continue;
        // Without conjugation.
        const Eigen::VectorXcd x = vectors.col(i).tail(n);
        add(s, x, 2.0 * s * (x.transpose() * x)(0) + (x.transpose() * (coupling * x))(0),
            coupled.first);
    }
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
        if (i >= coupled.first && i < coupled.last) continue;
        const double half = damping.at(i, i) / 2;
        const std::complex<double> root =
            std::sqrt(std::complex<double>(half * half - stiffness[i]));
        add(-half + root, Eigen::VectorXcd::Ones(1), 2.0 * root, i);
        if (root.imag() == 0) add(-half - root, Eigen::VectorXcd::Ones(1), -2.0 * root, i);
    }
    return poles;
}

}  // namespace aula
