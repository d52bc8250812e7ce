#include "information_shares.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace dynemo::life {
namespace {

constexpr int kRounds = 6, kHalvings = 12;
/// Less is not worth another round.
constexpr double kLeastShare = 0.02;
/// Of the way to where a direction is used up.
constexpr double kCaution = 0.95;

void addTo(MatrixX& sum, const PairMeasurement& m, double share) {
  const MatrixX JtWJ = share * (m.J.transpose() * m.information * m.J);
  sum.block(m.at_a, m.at_a, m.size_a, m.size_a) += JtWJ.topLeftCorner(m.size_a, m.size_a);
  sum.block(m.at_a, m.at_b, m.size_a, m.size_b) += JtWJ.topRightCorner(m.size_a, m.size_b);
  sum.block(m.at_b, m.at_a, m.size_b, m.size_a) += JtWJ.bottomLeftCorner(m.size_b, m.size_a);
  sum.block(m.at_b, m.at_b, m.size_b, m.size_b) += JtWJ.bottomRightCorner(m.size_b, m.size_b);
}

/// The largest share of one measurement that the remaining information (its inverse given) allows.
double headroom(const MatrixX& remaining_inverse, const PairMeasurement& m) {
  const MatrixX joint = jointBlock(remaining_inverse, m.at_a, m.size_a, m.at_b, m.size_b);
  const Eigen::LLT<MatrixX> llt(m.information);
  const MatrixX LtJ = llt.matrixU() * m.J;
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(LtJ * joint * LtJ.transpose(),
                                                     Eigen::EigenvaluesOnly);
  return 1.0 / eigen.eigenvalues().maxCoeff();
}

bool isPositive(const MatrixX& m) { return Eigen::LLT<MatrixX>(m).info() == Eigen::Success; }

}  // namespace

MatrixX jointBlock(const MatrixX& all, int at_a, int size_a, int at_b, int size_b) {
  MatrixX joint(size_a + size_b, size_a + size_b);
  joint << all.block(at_a, at_a, size_a, size_a), all.block(at_a, at_b, size_a, size_b),
      all.block(at_b, at_a, size_b, size_a), all.block(at_b, at_b, size_b, size_b);
  return joint;
}

std::vector<double> informationShares(const MatrixX& information,
                                      const std::vector<PairMeasurement>& measurements,
                                      double slack) {
  const Eigen::Index n = information.rows();
  MatrixX remaining = information + slack * MatrixX::Identity(n, n);
  std::vector<double> shares(measurements.size(), 0.0);
  for (int round = 0; round < kRounds; ++round) {
    const MatrixX inverse = Eigen::LLT<MatrixX>(remaining).solve(MatrixX::Identity(n, n));
    MatrixX growth = MatrixX::Zero(n, n);
    std::vector<std::size_t> growing;
    double step = 1.0;
    for (std::size_t i = 0; i < measurements.size(); ++i) {
      const double left = 1.0 - shares[i];
      if (left < kLeastShare || headroom(inverse, measurements[i]) < kLeastShare) continue;
      growing.push_back(i);
      step = std::min(step, left);
      addTo(growth, measurements[i], 1.0);
    }
    if (growing.empty()) break;
    int halvings = 0;
    while (halvings < kHalvings && !isPositive(remaining - step * growth)) {
      step *= 0.7;
      ++halvings;
    }
    if (halvings == kHalvings) break;
    if (halvings > 0) step *= kCaution;
    remaining -= step * growth;
    for (const std::size_t i : growing) shares[i] += step;
  }
  return shares;
}

}  // namespace dynemo::life
