/// @file
/// Fits the joints of a planar loop to its plane, which a description leaves by rounding.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/io/adf/adf_axis_turn.hpp>
#include <bristle/math/transform.hpp>

#include <cmath>
#include <optional>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// [1, m or rad] Largest error of a number in a file, which gives three digits after the point.
inline constexpr double adf_rounding = 0.5e-3;
/// [rad] Largest angle between two axes that are parallel but for rounding. Each is off by that of
/// the two numbers across it, and by those of its body's three angles. That makes sqrt(2) and
/// sqrt(3) roundings, each rounded up.
inline constexpr double adf_axis_rounding = 2.0 * (1.42 + 1.74) * adf_rounding;

/// A joint in a loop: its two frames in the world, as the bodies of the file stand.
struct AdfLoopJoint {
  /// Degrees of freedom.
  JointKind kind = JointKind::fixed;
  /// [m] Frame that the parent carries.
  Transform<double> X_WJa{};
  /// [m] Frame that the child carries.
  Transform<double> X_WJb{};
  /// [m] Largest distance of the frames that rounding explains.
  double largest_gap = 0.0;
};

/// How far a joint was out of the plane of its loop.
struct AdfOutOfPlane {
  /// [m] Distance of its frames across the plane.
  double gap = 0.0;
  /// [rad] Angle between the normals of the plane in its two frames.
  double tilt = 0.0;
};

/// The plane in which a loop moves: hinges are across it, slides along it.
class AdfPlane {
 public:
  /// None if the axes of hinges are not parallel, but for rounding.
  [[nodiscard]] static std::optional<AdfPlane> of(const std::vector<AdfLoopJoint>& loop) {
    AdfPlane plane;
    std::vector<Vec3<double>> axes;
    for (const AdfLoopJoint& joint : loop) {
      if (joint.kind != JointKind::revolute) continue;
      axes.push_back(joint.X_WJa.rotate(unit_x<Vec3<double>>()));
      axes.push_back(joint.X_WJb.rotate(unit_x<Vec3<double>>()));
    }
    if (axes.empty()) return std::nullopt;
    for (const Vec3<double>& axis : axes) {
      const double along = axes.front().dot(axis);
      if (!(axes.front().cross(axis).norm() <= adf_axis_rounding)) return std::nullopt;
      plane.normal_ += along > 0.0 ? axis : Vec3<double>(-axis);
    }
    plane.normal_.normalize();
    return plane;
  }

  /// Fits a joint to the plane, by turning and moving both of its frames by as much. A gap
  /// within the plane stays: the loop closes it by its own motion.
  ///
  /// @return How far it was out of the plane. None, and no fit, if that is more than rounding.
  [[nodiscard]] std::optional<AdfOutOfPlane> fit(AdfLoopJoint& joint) const {
    Transform<double>& a = joint.X_WJa;
    Transform<double>& b = joint.X_WJb;
    const double gap = (b.translation - a.translation).dot(normal_);
    if (!(std::abs(gap) <= joint.largest_gap)) return std::nullopt;
    AdfOutOfPlane out{.gap = std::abs(gap)};
    if (const std::optional<Vec3<double>> normal_J = normal_in(joint)) {
      // Both axes are close to the normal. They turn onto it exactly.
      const Vec3<double> of_a = a.rotate(*normal_J);
      const Vec3<double> of_b = b.rotate(*normal_J);
      out.tilt = of_a.cross(of_b).norm();
      for (const Vec3<double>& each : {of_a, of_b}) {
        if (!(each.cross(normal_).norm() <= adf_axis_rounding)) return std::nullopt;
      }
      a.rotation = (axis_turn(of_a, normal_) * a.rotation).normalized();
      b.rotation = (axis_turn(of_b, normal_) * b.rotation).normalized();
    }
    a.translation += 0.5 * gap * normal_;
    b.translation -= 0.5 * gap * normal_;
    return out;
  }

 private:
  /// Direction in the frames of a joint that is normal to the plane in both of its bodies. None
  /// where the joint lets them turn in any way.
  [[nodiscard]] std::optional<Vec3<double>> normal_in(const AdfLoopJoint& joint) const {
    const Vec3<double> x = unit_x<Vec3<double>>();
    switch (joint.kind) {
      case JointKind::revolute:
        return joint.X_WJa.rotate(x).dot(normal_) > 0.0 ? x : Vec3<double>(-x);
      case JointKind::prismatic:
      case JointKind::fixed: {
        Vec3<double> normal =
            joint.X_WJa.rotation.conjugate() * normal_ + joint.X_WJb.rotation.conjugate() * normal_;
        if (joint.kind == JointKind::prismatic) normal -= normal.dot(x) * x;
        return normal.normalized();
      }
      default:
        return std::nullopt;
    }
  }

  Vec3<double> normal_ = zero<Vec3<double>>();
};

/// Fits the joints of a planar loop to its plane. Axes that contradict each other by rounding would
/// jam it.
///
/// @return How far each joint was out of the plane. None, and no fit, if the loop is not planar but
///         for rounding.
[[nodiscard]] inline std::optional<std::vector<AdfOutOfPlane>> fit_loop(
    std::vector<AdfLoopJoint>& loop) {
  const std::optional<AdfPlane> plane = AdfPlane::of(loop);
  if (!plane) return std::nullopt;
  std::vector<AdfLoopJoint> fitted = loop;
  std::vector<AdfOutOfPlane> result;
  for (AdfLoopJoint& joint : fitted) {
    const std::optional<AdfOutOfPlane> out = plane->fit(joint);
    if (!out) return std::nullopt;
    result.push_back(*out);
  }
  loop = fitted;
  return result;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
