#include "dynemo/core/se3.h"

#include <gtest/gtest.h>

#include <numbers>

#include "random_values.h"

namespace dynemo::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-12;
constexpr double kDifference = 1e-6;
constexpr double kNumeric = 1e-8;  // of central differences
constexpr int kSamples = 200;

/// Angles where formulas change or lose digits.
const double kAngles[] = {0.0, 1e-12, 1e-9,    1e-7, 1e-5,       9e-4,       1.1e-3,    0.1,
                          1.0, 2.0,   kPi / 2, 3.0,  kPi - 1e-3, kPi - 1e-6, kPi - 1e-9};

TEST(Rotation, SkewIsTheCrossProduct) {
  RandomValues random(1);
  const Vector3 a = random.vector(2), b = random.vector(2);
  EXPECT_LT((skew(a) * b - a.cross(b)).norm(), kExact);
}

TEST(Rotation, ExpIsEigensAngleAxis) {
  RandomValues random(2);
  for (const double angle : kAngles) {
    const Vector3 u = random.direction();
    const Matrix3 expected = Eigen::AngleAxisd(angle, u).toRotationMatrix();
    EXPECT_LT((expSO3(angle * u) - expected).norm(), kExact) << angle;
  }
}

TEST(Rotation, LogUndoesExp) {
  RandomValues random(3);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Vector3 w = angle * random.direction();
      EXPECT_LT((logSO3(expSO3(w)) - w).norm(), 1e-15 + 1e-9 * angle) << "angle " << angle;
    }
  }
}

TEST(Rotation, LogAtExactlyPiIsAnAxisOfThatTurn) {
  RandomValues random(4);
  for (int i = 0; i < kSamples; ++i) {
    const Vector3 u = random.direction();
    const Vector3 w = logSO3(expSO3(kPi * u));
    EXPECT_NEAR(w.norm(), kPi, 1e-9);
    EXPECT_NEAR(std::abs(w.normalized().dot(u)), 1.0, 1e-9);
  }
}

TEST(Rotation, RightJacobianIsTheDerivativeOfExp) {
  RandomValues random(5);
  for (const double angle : kAngles) {
    const Vector3 w = angle * random.direction();
    Matrix3 numeric;
    for (int i = 0; i < 3; ++i) {
      const Vector3 d = kDifference * Vector3::Unit(i);
      numeric.col(i) = (logSO3(expSO3(w).transpose() * expSO3(w + d)) -
                        logSO3(expSO3(w).transpose() * expSO3(w - d))) /
                       (2 * kDifference);
    }
    EXPECT_LT((rightJacobianSO3(w) - numeric).norm(), kNumeric) << "angle " << angle;
  }
}

TEST(Rotation, InverseOfTheRightJacobian) {
  RandomValues random(6);
  for (const double angle : kAngles) {
    const Vector3 w = angle * random.direction();
    EXPECT_LT((rightJacobianInverseSO3(w) * rightJacobianSO3(w) - Matrix3::Identity()).norm(),
              1e-10)
        << angle;
  }
}

TEST(Rotation, NearestRotationProjects) {
  RandomValues random(7);
  for (int i = 0; i < kSamples; ++i) {
    const Matrix3 R = random.pose(kPi).R;
    EXPECT_LT((nearestRotation(R) - R).norm(), kExact);
    Matrix3 noise;
    noise << random.vector(0.1), random.vector(0.1), random.vector(0.1);
    const Matrix3 M = R + noise, projected = nearestRotation(M);
    EXPECT_NEAR(projected.determinant(), 1.0, kExact);
    // No rotation nearby is closer.
    for (int k = 0; k < 10; ++k) {
      EXPECT_LE((projected - M).norm(),
                (projected * expSO3(random.vector(0.01)) - M).norm() + kExact);
    }
  }
  EXPECT_NEAR(nearestRotation(-Matrix3::Identity()).determinant(), 1.0, kExact)
      << "a reflection is not a rotation";
}

TEST(Pose, InverseAndProduct) {
  RandomValues random(8);
  for (int i = 0; i < kSamples; ++i) {
    const Pose3 T = random.pose(kPi), S = random.pose(kPi);
    const Vector3 p = random.vector(3);
    EXPECT_LT(((T * S) * p - T * (S * p)).norm(), kExact);
    EXPECT_LT(local(Pose3(), T * T.inverse()).norm(), kExact);
    EXPECT_LT((T.inverse() * (T * p) - p).norm(), kExact);
  }
}

TEST(Pose, YawPitchRollTurnsInThatOrder) {
  const Pose3 T = Pose3::fromYawPitchRoll(1, 2, 3, kPi / 2, 0, 0);
  EXPECT_LT((T * Vector3(1, 0, 0) - Vector3(1, 3, 3)).norm(), kExact);
  const Pose3 U = Pose3::fromYawPitchRoll(0, 0, 0, kPi / 2, kPi / 2, 0);
  EXPECT_LT((U * Vector3(1, 0, 0) - Vector3(0, 0, -1)).norm(), kExact)
      << "positive pitch looks down";
  const Pose3 V = Pose3::fromYawPitchRoll(0, 0, 0, 0, 0, kPi / 2);
  EXPECT_LT((V * Vector3(0, 1, 0) - Vector3(0, 0, 1)).norm(), kExact);
}

TEST(Pose, LocalUndoesRetract) {
  RandomValues random(9);
  for (int i = 0; i < kSamples; ++i) {
    const Pose3 T = random.pose(kPi);
    const Vector6 d = random.tangent(1.5);
    EXPECT_LT((local(T, T.retract(d)) - d).norm(), 1e-11);
    const Pose3 S = random.pose(kPi);
    EXPECT_LT(local(T.retract(local(T, S)), S).norm(), 1e-11);
  }
}

TEST(Pose, QuaternionHasPositiveRealPartAndReadsBack) {
  RandomValues random(10);
  for (int i = 0; i < kSamples; ++i) {
    const Pose3 T = random.pose(kPi);
    const Eigen::Quaterniond q = T.quaternion();
    EXPECT_GE(q.w(), 0.0);
    EXPECT_NEAR(q.norm(), 1.0, kExact);
    EXPECT_LT((Pose3(q, T.t).R - T.R).norm(), kExact);
    EXPECT_LT((Pose3(Eigen::Quaterniond(3.0 * q.coeffs()), T.t).R - T.R).norm(), kExact)
        << "normalises its input";
  }
}

TEST(Pose, RetractKeepsRotationsOrthonormal) {
  RandomValues random(11);
  Pose3 T;
  for (int i = 0; i < 100'000; ++i) T = T.retract(random.tangent(0.1));
  EXPECT_LT((T.R.transpose() * T.R - Matrix3::Identity()).norm(), 1e-14);
}

TEST(Pose, InterpolationHitsTheEndsAndTurnsAtConstantRate) {
  RandomValues random(12);
  for (int i = 0; i < kSamples; ++i) {
    const Pose3 a = random.pose(kPi), b = a * random.pose(3.0);
    EXPECT_LT(local(interpolate(a, b, 0.0), a).norm(), kExact);
    EXPECT_LT(local(interpolate(a, b, 1.0), b).norm(), 1e-11);
    const double angle = rotationAngle(a.inverse() * b);
    for (const double s : {0.25, 0.5, 0.8}) {
      const Pose3 m = interpolate(a, b, s);
      EXPECT_NEAR(rotationAngle(a.inverse() * m), s * angle, 1e-10);
      EXPECT_LT((m.t - (a.t + s * (b.t - a.t))).norm(), kExact);
    }
  }
}

TEST(Pose, ComposeJacobiansAreDerivatives) {
  RandomValues random(13);
  for (int sample = 0; sample < kSamples; ++sample) {
    const Pose3 T = random.pose(kPi), T_c = random.pose(kPi);
    Matrix6 left, right;
    for (int i = 0; i < 6; ++i) {
      const Vector6 d = kDifference * Vector6::Unit(i);
      left.col(i) = (local(T * T_c, T.retract(d) * T_c) - local(T * T_c, T.retract(-d) * T_c)) /
                    (2 * kDifference);
      right.col(i) = (local(T * T_c, T * T_c.retract(d)) - local(T * T_c, T * T_c.retract(-d))) /
                     (2 * kDifference);
    }
    EXPECT_LT((composeJacobianLeft(T_c) - left).norm(), kNumeric);
    EXPECT_LT((composeJacobianRight() - right).norm(), kNumeric);
  }
}

TEST(Pose, CovarianceAxesThereAndBack) {
  RandomValues random(14);
  const Matrix6 cov = random.spd(6);
  const Matrix3 R = random.pose(kPi).R;
  const Matrix6 parent = covarianceTranslationToParent(cov, R);
  EXPECT_LT((covarianceTranslationToLocal(parent, R) - cov).norm(), kExact);
  EXPECT_LT((parent.topLeftCorner<3, 3>() - R * cov.topLeftCorner<3, 3>() * R.transpose()).norm(),
            kExact);
  EXPECT_LT((parent.bottomRightCorner<3, 3>() - cov.bottomRightCorner<3, 3>()).norm(), kExact)
      << "rotation stays about the pose's own axes";
}

TEST(Pose, NotFiniteIsSeen) {
  Pose3 T;
  EXPECT_TRUE(T.isFinite());
  T.t.y() = std::nan("");
  EXPECT_FALSE(T.isFinite());
  T = Pose3();
  T.R(1, 1) = INFINITY;
  EXPECT_FALSE(T.isFinite());
}

}  // namespace
}  // namespace dynemo::test
