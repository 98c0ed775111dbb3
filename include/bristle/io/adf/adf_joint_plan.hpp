/// @file
/// Joints of an AMBF description between reading and adding: those that close loops are fitted.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/io/adf/adf_body_builder.hpp>
#include <bristle/io/adf/adf_loop_fit.hpp>
#include <bristle/io/adf/adf_loops.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// A joint that is about to be added.
template <Scalar S>
struct AdfPlannedJoint {
  const AdfJoint* joint = nullptr;
  JointDef<S> def{};
  /// [m] Poses of its bodies.
  Transform<S> X_WA{};
  Transform<S> X_WB{};
  /// [-] Numbers of its bodies. All bodies that do not move have one.
  std::size_t node_a = 0;
  std::size_t node_b = 0;
  /// [1] Scales of its bodies.
  double scale_a = 1.0;
  double scale_b = 1.0;
  /// How far it was out of the plane of its loop, before it was fitted.
  AdfOutOfPlane out_of_plane{};

  /// Returns its frames as the bodies stand.
  [[nodiscard]] AdfLoopJoint in_loop() const {
    const auto of_rounding = [](double scale, const Transform<S>& X) {
      // Each of three coordinates of the body, its pivot and its angles.
      return 1.74 * adf_rounding * (1.0 + scale + static_cast<double>(X.translation.norm()));
    };
    return {.kind = def.kind,
            .X_WJa = cast(X_WA * def.X_AJ),
            .X_WJb = cast(X_WB * def.X_BJ),
            .largest_gap = of_rounding(scale_a, def.X_AJ) + of_rounding(scale_b, def.X_BJ)};
  }

  /// Takes the frames of a fit.
  void take(const AdfLoopJoint& fitted, const AdfOutOfPlane& was) {
    out_of_plane = was;
    def.X_AJ = scaled_pose<S>(cast(X_WA).inverse() * fitted.X_WJa, 1.0);
    def.X_BJ = scaled_pose<S>(cast(X_WB).inverse() * fitted.X_WJb, 1.0);
    def.X_AJ.rotation.normalize();
    def.X_BJ.rotation.normalize();
  }

 private:
  [[nodiscard]] static Transform<double> cast(const Transform<S>& X) {
    return {X.rotation.template cast<double>().normalized(), X.translation.template cast<double>()};
  }
};

/// Fits the joints of each planar loop to its plane, where only rounding takes them out of it.
/// Others stay as they are.
template <Scalar S>
void fit_loops(std::vector<AdfPlannedJoint<S>>& joints) {
  std::size_t nodes = 0;
  std::vector<AdfConnection> connections;
  std::vector<AdfPlannedJoint<S>*> connecting;
  for (AdfPlannedJoint<S>& planned : joints) {
    // A joint that leaves all free holds nothing together.
    if (planned.def.kind == JointKind::six_dof) continue;
    nodes = std::max({nodes, planned.node_a + 1, planned.node_b + 1});
    connections.emplace_back(planned.node_a, planned.node_b);
    connecting.push_back(&planned);
  }
  const AdfLoops loops(nodes, connections);
  for (const std::vector<std::size_t>& set : loops.sets()) {
    std::vector<AdfLoopJoint> loop;
    for (const std::size_t i : set) loop.push_back(connecting[i]->in_loop());
    const auto was = fit_loop(loop);
    if (!was) continue;
    for (std::size_t i = 0; i < set.size(); ++i) connecting[set[i]]->take(loop[i], (*was)[i]);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
