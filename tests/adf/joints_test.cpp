// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/io/adf/adf_joint_builder.hpp>
#include <bristle/io/adf/adf_reader.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

using namespace bristle;

using namespace bristle::detail;

namespace {

using V = Vec3<double>;
using Q = Quat<double>;

}  // namespace

TEST_CASE("add_adf: joints stand at zero where axes and offsets say") {
  // Parent axis p, child axis c and offset t: the child's attitude at zero is that of c turned the
  // shortest way onto p, then turned by t about p.
  struct Case {
    const char* parent;
    const char* child;
    double offset;
    Q R_AB;
  };
  const double quarter = std::numbers::pi / 2;
  const Q x90(Eigen::AngleAxis<double>(quarter, V::UnitX()));
  const Q z180(0, 0, 0, 1);
  const Q y180(0, 0, 1, 0);
  const Q x180(0, 1, 0, 0);
  for (const Case& c :
       {Case{"{x: 0, y: 0, z: 1}", "{x: 0, y: 0, z: 1}", 0, Q::Identity()},
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 0, z: 1}", 0, x90},
        // Opposite axes: half a turn about child x X, or about child x Y where X is along it.
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 1, z: 0}", 0, z180},
        Case{"{x: 0, y: 0, z: -1}", "{x: 0, y: 0, z: 1}", 0, y180},
        Case{"{x: -1, y: 0, z: 0}", "{x: 1, y: 0, z: 0}", 0, z180},
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 1, z: 0}", std::numbers::pi, x180},
        Case{"{x: 2, y: 0, z: 0}", "{x: 3, y: 0, z: 0}", quarter, x90}}) {
    CAPTURE(c.parent);
    CAPTURE(c.child);
    AdfJoint joint =
        read_adf(std::string("joints: [J]\nJ: {type: hinge, parent: A, child: B, parent pivot: {x: "
                             "1, y: 2, z: 3}, child pivot: {x: 0, y: 1, z: 0}, parent axis: ") +
                     c.parent + ", child axis: " + c.child +
                     ", offset: " + detail::to_text(c.offset) + "}\n",
                 "scene.yaml")
            .joints.at(0);
    joint.offset = c.offset;
    const auto frames = detail::joint_frames<double>(joint, 2.0, 3.0);
    // At zero the two frames coincide.
    const Q R = frames.X_AJ.rotation * frames.X_BJ.rotation.conjugate();
    CHECK(R.angularDistance(c.R_AB) < 1e-15);
    // The free axis is the x axis of both.
    CHECK((frames.X_AJ.rotate(V::UnitX()) - joint.parent_axis).norm() < 1e-15);
    CHECK((frames.X_BJ.rotate(V::UnitX()) - joint.child_axis).norm() < 1e-15);
    CHECK(frames.X_AJ.translation == V(2, 4, 6));
    CHECK(frames.X_BJ.translation == V(0, 3, 0));
  }
}

TEST_CASE("add_adf: joints with three axes have them where the format has them") {
  for (const char* type : {"cone twist", "six dof", "six dof spring"}) {
    CAPTURE(type);
    const AdfJoint joint =
        read_adf(std::string("joints: [J]\nJ: {type: ") + type +
                     ", parent: A, child: B, parent pivot: {x: 0, y: 0, z: 0}, child pivot: {x: "
                     "0, y: 0, z: 0}, parent axis: {x: 0, y: 0, z: 1}, child axis: {x: 0, y: 0, z: "
                     "1}, joint offset: 0.3, offset: 0.5}\n",
                 "scene.yaml")
            .joints.at(0);
    const auto frames = detail::joint_frames<double>(joint, 1.0, 1.0);
    // z along the axis, x and y turned about it.
    CHECK((frames.X_AJ.rotate(V::UnitZ()) - joint.parent_axis).norm() < 1e-15);
    CHECK((frames.X_BJ.rotate(V::UnitZ()) - joint.child_axis).norm() < 1e-15);
    CHECK((frames.X_AJ.rotate(V::UnitX()) - V(std::cos(0.3), std::sin(0.3), 0)).norm() < 1e-15);
    // The child stands by its own offset alone.
    const Q R = frames.X_AJ.rotation * frames.X_BJ.rotation.conjugate();
    CHECK(R.angularDistance(Q(Eigen::AngleAxis<double>(0.5, V::UnitZ()))) < 1e-15);
  }
}

TEST_CASE("axis_turn: brings any direction onto any other") {
  for (int i = 0; i < 100; ++i) {
    const double t = std::numbers::pi * i / 99.0;
    const V from = V(0.3, -0.5, 0.8).normalized();
    const V side = from.cross(V(0.1, 0.9, 0.2)).normalized();
    const V to = std::cos(t) * from + std::sin(t) * side;
    const Q q = detail::axis_turn(from, to.normalized());
    CHECK((q * from - to).norm() < 1e-14);
    // By the shortest way, but for the last degree before the opposite.
    if (t < 3.12) CHECK(q.angularDistance(Q::Identity()) == test::relative(t).epsilon(1e-9));
  }
}

TEST_CASE("add_adf: joints of each kind") {
  const std::string common =
      "parent: P, child: C, parent pivot: {x: 0, y: 0, z: 0}, child pivot: {x: 0, y: 0, z: 0}, "
      "parent axis: {x: 0, y: 0, z: 1}, child axis: {x: 0, y: 0, z: 1}";
  const auto joint_of = [&](const std::string& type, const std::string& more,
                            const AdfBuildDef<double>& def = {}) {
    const AdfModel model =
        read_adf(std::string("bodies: [P, C]\nP: {mass: 1}\nC: {mass: 1}\n") +
                     "joints: [J]\nJ: {type: " + type + ", " + common + more + "}\n",
                 "scene.yaml");
    AdfReport report;
    detail::AdfJointBuilder<double> builder(def, report);
    // The child stands 0.25 m along and 0.5 rad about the axis from zero.
    const Transform<double> X_WB{Q(Eigen::AngleAxis<double>(0.5, V::UnitZ())), {0, 0, 0.25}};
    JointDef<double> result = builder.joint(model.joints.at(0), 1.0, 1.0);
    builder.hold(model.joints.at(0), {}, X_WB, result);
    return result;
  };
  CHECK(joint_of("fixed", "").kind == JointKind::fixed);
  CHECK(joint_of("p2p", "").kind == JointKind::ball);
  CHECK(joint_of("six dof", "").kind == JointKind::six_dof);
  CHECK_FALSE(joint_of("fixed", "").bodies_collide);
  CHECK(joint_of("fixed", ", ignore inter-collision: false").bodies_collide);

  const JointDef<double> hinge =
      joint_of("hinge", ", joint limits: {low: -4, high: 5}, stiffness: 2, damping: 3");
  CHECK(hinge.kind == JointKind::revolute);
  CHECK(hinge.lower_limit == -4.0);
  CHECK(hinge.upper_limit == 5.0);
  CHECK(hinge.spring.stiffness == 2.0);
  CHECK(hinge.spring.damping == 3.0);
  CHECK(hinge.spring.rest == 0.5);
  CHECK(hinge.motor.mode == MotorMode::none);
  CHECK(joint_of("linear spring", ", stiffness: 2").kind == JointKind::prismatic);
  CHECK(joint_of("torsion spring", ", stiffness: 2").kind == JointKind::revolute);

  const JointDef<double> cone = joint_of("cone twist", ", joint limits: {x: 0.1, y: 0.3, z: 0.2}");
  CHECK(cone.kind == JointKind::cone_twist);
  CHECK(cone.lower_limit == -0.1);
  CHECK(cone.upper_limit == 0.1);
  CHECK(cone.swing_limit == 0.2);

  const JointDef<double> bushing = joint_of(
      "six dof spring", ", stiffness: {linear: {x: 1, y: 2, z: 3}, angular: {x: 4, y: 5, z: 6}}");
  CHECK(bushing.kind == JointKind::six_dof);
  CHECK(bushing.bushing.stiffness[2] == 3.0);
  CHECK(bushing.bushing.stiffness[3] == 4.0);

  // Held where they stand, beside a spring of their own.
  const AdfBuildDef<double> held{.hold_joints = true};
  const JointDef<double> slide = joint_of("slider", ", controller: {P: 100, D: 7}", held);
  CHECK(slide.spring.stiffness == 100.0);
  CHECK(slide.spring.damping == 7.0);
  CHECK(slide.spring.rest == test::relative(0.25));
  const JointDef<double> both = joint_of(
      "hinge", ", controller: {P: 30, D: 7}, stiffness: 10, equilibrium point: 0.1, damping: 1",
      held);
  CHECK(both.spring.stiffness == 40.0);
  CHECK(both.spring.damping == 8.0);
  CHECK(both.spring.rest == test::relative(0.4));  // (10 x 0.1 + 30 x 0.5) / 40
  // Of the turns an angle can mean, the one at the limits.
  CHECK(joint_of("hinge", ", controller: {P: 1}, joint limits: {low: 6, high: 7}", held)
            .spring.rest == test::relative(0.5 + 2 * std::numbers::pi));
  const JointDef<double> motor = joint_of("hinge", ", max motor impulse: 0.02", held);
  CHECK(motor.motor.mode == MotorMode::velocity);
  CHECK(motor.motor.target == 0.0);
  CHECK(motor.motor.max_force == test::relative(20.0));
}
