// Edges of the scene graph: the factors of the optimisation.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <array>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "dynemo/core/ids.h"
#include "dynemo/core/noise.h"
#include "dynemo/graph/robust_kernel.h"

namespace dynemo {

/// At most 6 residuals and 4 nodes per edge: evaluating one never allocates.
constexpr int kMaxResidual = 6;
constexpr int kMaxTangent = 6;
constexpr int kMaxEdgeNodes = 4;
using Residual = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxResidual, 1>;
using JacobianBlock =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxResidual, kMaxTangent>;
using Jacobians = std::array<JacobianBlock, kMaxEdgeNodes>;
using InformationMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxResidual, kMaxResidual>;

/// One factor: cost ½ ρ(eᵀ Ω e) with the residual e a function of the states of its nodes.
class CEdgeBase : public mrpt::serialization::CSerializable {
  DEFINE_VIRTUAL_SERIALIZABLE(CEdgeBase)
 public:
  EdgeId id{};
  /// In the order in which evaluate() takes their states.
  std::vector<NodeId> nodes;
  RobustKernel kernel;

  virtual int residualSize() const = 0;
  /// e at the given node states (CNodeBase::readState layout, one pointer per node) and, when J is
  /// given, the derivative of e by each node's tangent.
  virtual void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const = 0;
  /// Short name for files and pictures: "odometry", "keyframe_entity", …
  virtual const char* kind() const = 0;

  /// Sets Ω. Throws DataError, naming the edge's kind, when it is not symmetric positive definite.
  void setInformation(const MatrixX& information);
  void setCovariance(const MatrixX& covariance);
  const InformationMatrix& information() const { return information_; }
  /// U with UᵀU = Ω.
  const InformationMatrix& sqrtInformation() const { return sqrt_information_; }

 protected:
  void writeBase(mrpt::serialization::CArchive& out) const;
  void readBase(mrpt::serialization::CArchive& in);

 private:
  InformationMatrix information_, sqrt_information_;
};

/// A random symmetric positive definite matrix, for examples and tests.
MatrixX randomInformation(int size, std::mt19937_64& rng);
/// A random pose with any rotation and translations up to a few metres.
Pose3 randomPose(std::mt19937_64& rng);

}  // namespace dynemo
