#include "pair_information.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace dynemo::life {
namespace {

constexpr int kRounds = 20;
/// Change of a share of what is known that is not worth another round.
constexpr double kSmallChange = 0.01;

/// Rows of the two blocks of P, and their columns of J: P Jᵀ.
MatrixX timesTransposed(const MatrixX& P, const PairMeasurement& m) {
  return P.middleCols(m.at_a, m.size_a) * m.J.leftCols(m.size_a).transpose() +
         P.middleCols(m.at_b, m.size_b) * m.J.rightCols(m.size_b).transpose();
}

MatrixX times(const PairMeasurement& m, const MatrixX& G) {
  return m.J.leftCols(m.size_a) * G.middleRows(m.at_a, m.size_a) +
         m.J.rightCols(m.size_b) * G.middleRows(m.at_b, m.size_b);
}

}  // namespace

MatrixX jointBlock(const MatrixX& all, int at_a, int size_a, int at_b, int size_b) {
  MatrixX joint(size_a + size_b, size_a + size_b);
  joint << all.block(at_a, at_a, size_a, size_a), all.block(at_a, at_b, size_a, size_b),
      all.block(at_b, at_a, size_b, size_a), all.block(at_b, at_b, size_b, size_b);
  return joint;
}

std::vector<MatrixX> pairInformation(int size, const std::vector<PairMeasurement>& measurements,
                                     double slack) {
  std::vector<MatrixX> X, root;  // root: M = L Lᵀ
  for (const PairMeasurement& m : measurements) {
    X.push_back(MatrixX::Zero(m.J.rows(), m.J.rows()));
    root.push_back(Eigen::LLT<MatrixX>(m.covariance).matrixL());
  }
  MatrixX P = MatrixX::Identity(size, size) / slack;  // Λ'⁻¹
  for (int round = 0; round < kRounds; ++round) {
    double change = 0.0;
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      const PairMeasurement& m = measurements[i];
      const Eigen::Index rows = m.J.rows();
      const MatrixX I = MatrixX::Identity(rows, rows);
      const MatrixX G = timesTransposed(P, m), S = times(m, G);
      const MatrixX& L = root[i];
      // What the others say, in units of what is known: eigenvalues b of Lᵀ (S⁻¹ − X) L.
      const MatrixX known = L.transpose() * Eigen::LLT<MatrixX>(S).solve(L);
      const MatrixX own = L.transpose() * X[i] * L;
      const Eigen::SelfAdjointEigenSolver<MatrixX> others(0.5 * (known + known.transpose()) - own);
      const VectorX missing = (1.0 - others.eigenvalues().array()).cwiseMax(0.0).cwiseMin(1.0);
      const MatrixX& V = others.eigenvectors();
      const MatrixX scaled = V * missing.asDiagonal() * V.transpose();
      change = std::max(change, (scaled - own).cwiseAbs().maxCoeff());
      const MatrixX half = L.transpose().triangularView<Eigen::Upper>().solve(scaled);
      MatrixX next = L.transpose().triangularView<Eigen::Upper>().solve(half.transpose());
      next = 0.5 * (next + next.transpose()).eval();
      const MatrixX D = next - X[i];
      X[i] = next;
      // (Λ' + Jᵀ D J)⁻¹ = P − G D (I + S D)⁻¹ Gᵀ.
      const MatrixX inner = (I + D * S).partialPivLu().solve(D);
      P.noalias() -= G * (0.5 * (inner + inner.transpose())) * G.transpose();
    }
    if (change < kSmallChange) break;
  }
  return X;
}

}  // namespace dynemo::life
