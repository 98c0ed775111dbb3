/// @file
/// The pinch in ODE, what joints leave free, and rays at mirrored shapes, against ODE itself.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/ode_pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// [m/s/N] Softness of joints that hold the same twice: without, ODE divides by zero.
constexpr double ode_cfm = 1e-13;

/// A tilted body with three moments of inertia, from 0.008 to 0.033 kg m^2, that is not pulled back
/// into its joints.
dBodyID ode_tumbler(OdeWorld& ode) {
  dWorldSetERP(ode.id, 0);
  const dBodyID body = ode.add_box(2, {0.1, 0.2, 0.4}, {0.1, -0.2, 0.3});
  dQuaternion q;
  dQFromAxisAndAngle(q, 1, 2, 3, 0.8);
  dBodySetQuaternion(body, q);
  return body;
}

struct OdeJoints {
  std::string name;
  /// Makes them between a body and another, or the world.
  std::function<void(dWorldID, dBodyID, dBodyID)> make;
};

/// Joints of each kind that hosts know, in general position, and some that hold the same twice.
std::vector<OdeJoints> ode_joints() {
  const auto hinge_at = [](double x, double y, double z) {
    return [=](dWorldID world, dBodyID a, dBodyID b) {
      const dJointID joint = dJointCreateHinge(world, nullptr);
      dJointAttach(joint, a, b);
      dJointSetHingeAnchor(joint, x, y, z);
      dJointSetHingeAxis(joint, 2, -1, 0.5);
    };
  };
  const auto ball_at = [](double x, double y, double z) {
    return [=](dWorldID world, dBodyID a, dBodyID b) {
      const dJointID joint = dJointCreateBall(world, nullptr);
      dJointAttach(joint, a, b);
      dJointSetBallAnchor(joint, x, y, z);
    };
  };
  std::vector<OdeJoints> joints;
  joints.push_back({"none", [](dWorldID, dBodyID, dBodyID) {}});
  joints.push_back({"slider", [](dWorldID world, dBodyID a, dBodyID b) {
                      const dJointID joint = dJointCreateSlider(world, nullptr);
                      dJointAttach(joint, a, b);
                      dJointSetSliderAxis(joint, 0.6, 0, 0.8);
                    }});
  joints.push_back({"hinge", hinge_at(0.4, 0.1, 0.2)});
  joints.push_back({"ball", ball_at(-0.1, 0.1, 0.6)});
  joints.push_back({"universal", [](dWorldID world, dBodyID a, dBodyID b) {
                      const dJointID joint = dJointCreateUniversal(world, nullptr);
                      dJointAttach(joint, a, b);
                      dJointSetUniversalAnchor(joint, 0.2, 0, 0.1);
                      dJointSetUniversalAxis1(joint, 0.6, 0.8, 0);
                      dJointSetUniversalAxis2(joint, -0.8, 0.6, 0);
                    }});
  joints.push_back({"piston", [](dWorldID world, dBodyID a, dBodyID b) {
                      const dJointID joint = dJointCreatePiston(world, nullptr);
                      dJointAttach(joint, a, b);
                      dJointSetPistonAnchor(joint, 0.3, -0.1, 0.3);
                      dJointSetPistonAxis(joint, 1, 2, -2);
                    }});
  joints.push_back({"fixed", [](dWorldID world, dBodyID a, dBodyID b) {
                      const dJointID joint = dJointCreateFixed(world, nullptr);
                      dJointAttach(joint, a, b);
                      dJointSetFixed(joint);
                    }});
  joints.push_back({"two balls", [=](dWorldID world, dBodyID a, dBodyID b) {
                      dWorldSetCFM(world, ode_cfm);
                      ball_at(0.3, 0, 0.3)(world, a, b);
                      ball_at(-0.3, 0.1, 0.2)(world, a, b);
                    }});
  joints.push_back({"two hinges", [=](dWorldID world, dBodyID a, dBodyID b) {
                      dWorldSetCFM(world, ode_cfm);
                      hinge_at(0.4, 0.1, 0.2)(world, a, b);
                      hinge_at(-1.6, 1.1, -0.3)(world, a, b);
                    }});
  return joints;
}

}  // namespace

TEST_CASE("ODE: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  check_holds<OdePinch>({.mass = 0.045, .squeeze = 12}, {});
  check_holds<OdePinch>({.mass = 2, .squeeze = 60}, {});
}

TEST_CASE("ODE: a part whose centre of mass lies beside the pads is held against turning") {
  check_holds<OdePinch>({.squeeze = 30, .offset = 0.04}, {});
}

TEST_CASE("ODE: the squeeze decides whether a part is held or let go") {
  check_lets_go<OdePinch>();
}

TEST_CASE("ODE: a shaken part swings as a spring and damper does, and comes back") {
  check_shaken<OdePinch>();
}

TEST_CASE("ODE: pads that come from out of reach catch a part in a long step") {
  check_caught<OdePinch>({});
}

TEST_CASE("ODE: the part gains the momentum that readings tell") { check_momentum<OdePinch>({}); }

TEST_CASE("ODE: a body that a caller adds to the mirror himself is missing, and harms nobody") {
  check_stranger<OdePinch>();
}

TEST_CASE("ODE: the quick step holds, too, and a part that would fall asleep stays awake") {
  OdePinch pinch{{}};
  dBodySetAutoDisableFlag(pinch.part_body, 1);
  pinch.run(0.5);
  pinch.gravity = {0, 0, -9.81};
  const auto run_quickly = [&](double seconds) {
    for (long i = 0; i < std::lround(seconds / pinch.def.dt); ++i) {
      pinch.push();
      pinch.host.sense(pinch.def.dt);
      dWorldQuickStep(pinch.ode.id, pinch.def.dt);
    }
  };
  run_quickly(1.5);
  const double there = pinch.place().z();
  run_quickly(2);
  CHECK(std::abs(pinch.place().z() - there) < 2e-9);
  CHECK(dBodyIsEnabled(pinch.part_body) == 1);
  CHECK(pinch.weight() == test::relative(pinch.def.mass * 9.81).epsilon(1e-9));
}

TEST_CASE("ODE: a body's mobility is what a step of ODE's does to it") {
  const double dt = 1e-3;
  for (const OdeJoints& joints : ode_joints()) {
    CAPTURE(joints.name);
    OdeWorld ode;
    const dBodyID body = ode_tumbler(ode);
    joints.make(ode.id, body, nullptr);
    OdeHost<> host(ode.id);
    const BodyId id = host.mirror(body);
    const Mat6<double> W = host.mobility(id, id);
    CHECK((W - W.transpose()).norm() < 1e-15 / 0.008);
    const Wrench<double> wrench{{3, -2, 5}, {0.4, 0.3, -0.2}};
    Vec6<double> w;
    w << wrench.force, wrench.torque;
    host.apply_wrench(id, wrench);
    dWorldStep(ode.id, dt);
    // A wrench that gives 0.07 m/s and rad/s without joints, rounded, times the condition of their
    // rows, below 1e3. Soft joints give way by their forces, below 30 N, times their softness.
    CHECK((ode_twist(body) - dt * W * w).norm() < 2e-14 + 30 * dWorldGetCFM(ode.id));
  }
}

TEST_CASE("ODE: the acceleration leads to the twist after a step, also on a base that moves") {
  const double dt = 2e-3;
  for (const OdeJoints& joints : ode_joints()) {
    for (int order = 0; order < 3; ++order) {
      CAPTURE(joints.name);
      CAPTURE(order);
      OdeWorld ode;
      dWorldSetGravity(ode.id, 1, 2, -9.81);
      const dBodyID body = ode_tumbler(ode);
      const dBodyID base = ode.add_box(1, {0.1, 0.1, 0.1}, {0.5, 0.4, 0.3});
      dBodySetKinematic(base);
      dBodySetLinearVel(base, 0.3, -0.1, 0.2);
      dBodySetAngularVel(base, 1, 0.5, -0.7);
      if (order == 0) joints.make(ode.id, body, nullptr);
      if (order == 1) joints.make(ode.id, body, base);
      if (order == 2) joints.make(ode.id, base, body);
      dBodySetLinearVel(body, 0.1, 0.2, -0.3);
      dBodySetAngularVel(body, 4, -3, 5);
      dBodyAddForce(body, 1, 2, 3);
      dBodyAddTorque(body, 0.3, -0.2, 0.1);
      OdeHost<> host(ode.id);
      const BodyId id = host.mirror(body);
      const BodyId base_id = host.mirror(base);
      host.sense(dt);
      const HostBody<double> before = host.body(id).value();
      CHECK(host.mobility(base_id, base_id) == Mat6<double>::Zero());
      CHECK(host.body(base_id)->acceleration.angular == Vec3<double>::Zero());
      dWorldStep(ode.id, dt);
      Vec6<double> found;
      found << before.twist.linear + dt * before.acceleration.linear,
          before.twist.angular + dt * before.acceleration.angular;
      // As above, for 7 rad/s, and 1000 N that stop 2 kg from 1 m/s within the step.
      CHECK((ode_twist(body) - found).norm() < 2e-12 + 1000 * dWorldGetCFM(ode.id));
    }
  }
}

TEST_CASE("ODE: a body on a plane joint, and joints that hold nothing") {
  OdeWorld ode;
  const dBodyID body = ode_tumbler(ode);
  const dBodyID other = ode_tumbler(ode);
  OdeHost<> host(ode.id);
  const BodyId id = host.mirror(body);
  const Mat6<double> free = host.mobility(id, id);
  ode_joints()[1].make(ode.id, body, other);
  CHECK(host.mobility(id, id) == free);
  CHECK(host.mobility(id, host.mirror(other)) == Mat6<double>::Zero());
  const dJointID plane = dJointCreatePlane2D(ode.id, nullptr);
  dJointAttach(plane, body, nullptr);
  Mat6<double> expected = Mat6<double>::Zero();
  expected(0, 0) = expected(1, 1) = 0.5;
  expected(5, 5) = 1 / free.bottomRightCorner<3, 3>().inverse().eval()(2, 2);
  CHECK((host.mobility(id, id) - expected).norm() < 1e-12 * free.norm());
  dJointDisable(plane);
  CHECK(host.mobility(id, id) == free);
}

TEST_CASE("ODE: what a caller applies stays, and acts for one step") {
  OdePinch pinch{{}};
  const dBodyID far = pinch.ode.add_box(1, {0.01, 0.01, 0.01}, {0, 0, 1});
  (void)pinch.host.mirror(far);
  for (int i = 0; i < 300; ++i) {
    dBodyAddForce(pinch.part_body, 0, 0.25, 0);
    dBodyAddForce(far, 0, 0.5, 0);
    pinch.push();
    pinch.host.sense(pinch.def.dt);
    CHECK(ode_vector(dBodyGetForce(far)) == Vec3<double>(0, 0.5, 0));
    dWorldStep(pinch.ode.id, pinch.def.dt);
    CHECK(ode_vector(dBodyGetForce(pinch.part_body)) == Vec3<double>::Zero());
  }
  CHECK(pinch.reading(0).wrench.force.y() + pinch.reading(1).wrench.force.y() ==
        test::relative(0.25).epsilon(1e-3));
}

TEST_CASE("ODE: rays meet mirrored geoms where they meet ODE's") {
  const std::vector<std::function<dGeomID(dSpaceID)>> makers{
      [](dSpaceID space) { return dCreateBox(space, 0.4, 0.6, 0.8); },
      [](dSpaceID space) { return dCreateSphere(space, 0.3); },
      [](dSpaceID space) { return dCreateCapsule(space, 0.2, 0.5); },
      [](dSpaceID space) { return dCreateCylinder(space, 0.25, 0.8); },
      [](dSpaceID space) { return dCreatePlane(space, 0.6, 2, 8, 1.2); },
      [](dSpaceID space) {
        // A tetrahedron whose faces look inwards.
        static const dReal corners[] = {0, 0, 0, 0.9, 0, 0, 0, 0.8, 0, 0, 0, 1};
        static const dTriIndex faces[] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
        static const dTriMeshDataID mesh = [] {
          const dTriMeshDataID data = dGeomTriMeshDataCreate();
          dGeomTriMeshDataBuildDouble(data, corners, 3 * sizeof(dReal), 4, faces, 12,
                                      3 * sizeof(dTriIndex));
          return data;
        }();
        return dCreateTriMesh(space, mesh, nullptr, nullptr, nullptr);
      }};
  const dGeomID ray = dCreateRay(nullptr, 10);
  dGeomRaySetClosestHit(ray, 1);
  for (std::size_t kind = 0; kind < makers.size(); ++kind) {
    for (const bool has_body : {true, false}) {
      CAPTURE(kind);
      CAPTURE(has_body);
      OdeWorld ode;
      OdeHost<> host(ode.id);
      const dGeomID geom = makers[kind](ode.space);
      dQuaternion q;
      dQFromAxisAndAngle(q, 0.6, 0, 0.8, 0.7);
      if (dGeomGetClass(geom) == dPlaneClass) {
        if (has_body) continue;
      } else if (has_body) {
        const dBodyID body = ode_tumbler(ode);
        dGeomDestroy(dBodyGetFirstGeom(body));
        dGeomSetBody(geom, body);
        dGeomSetOffsetPosition(geom, 0.1, 0, -0.2);
        dGeomSetOffsetQuaternion(geom, q);
        // A ray that a body casts in ODE is no part of it.
        dGeomSetBody(dCreateRay(ode.space, 1), body);
        CHECK(host.mirror(body) == host.mirror(body));
      } else {
        dGeomSetPosition(geom, 0.1, -0.2, 0.3);
        dGeomSetQuaternion(geom, q);
      }
      if (!has_body) CHECK(host.mirror_ground(geom) == host.mirror_ground(geom));
      CHECK(host.world().body_count() == 1);
      int hits = 0;
      for (int i = 0; i < 200; ++i) {
        const double angle = 2.4 * i;
        const Vec3<double> from(2 * std::cos(angle), 2 * std::sin(angle), 1.2 + 0.01 * (i - 100));
        const Vec3<double> to(0.1 + 0.4 * std::sin(1.0 * i), 0.002 * i - 0.4, 0.002 * i);
        const Vec3<double> along = (to - from).normalized();
        dGeomRaySet(ray, from.x(), from.y(), from.z(), along.x(), along.y(), along.z());
        const WorldHit<double> hit = host.world().cast_ray({from, along, 10});
        dContactGeom contact;
        const bool is_hit = dCollide(ray, geom, 1, &contact, sizeof(contact)) > 0;
        // ODE meets planes from behind, too; there a ray starts inside of what is mirrored.
        if (hit.distance == 0) continue;
        CHECK(hit.is_hit() == is_hit);
        if (!hit.is_hit() || !is_hit) continue;
        ++hits;
        // Of meshes ODE counts in float.
        const bool is_mesh = dGeomGetClass(geom) == dTriMeshClass;
        CHECK(hit.distance == test::relative(contact.depth).epsilon(is_mesh ? 1e-5 : 1e-9));
        // Its normals follow the winding.
        const Vec3<double> normal = (is_mesh ? -1 : 1) * ode_vector(contact.normal);
        CHECK((hit.normal - normal).norm() < (is_mesh ? 1e-5 : 1e-7));
      }
      CHECK(hits > 40);
      CHECK(hits < 200);
    }
  }
  dGeomDestroy(ray);
}

TEST_CASE("ODE: geoms without a shape like them are refused by name, and a body is let go") {
  OdePinch pinch{{}};
  const dReal corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const dTriIndex triangle[] = {0, 1, 2};
  const dTriMeshDataID mesh = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(mesh, corners, 3 * sizeof(dReal), 3, triangle, 3,
                              3 * sizeof(dTriIndex));
  const dGeomID geom = dCreateTriMesh(pinch.ode.space, mesh, nullptr, nullptr, nullptr);
  const dBodyID body = dBodyCreate(pinch.ode.id);
  const std::uint64_t before = pinch.host.world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host.mirror_ground(geom), doctest::Contains("must be closed"),
                       InvalidArgument);
  dGeomSetBody(geom, body);
  CHECK_THROWS_WITH_AS(pinch.host.mirror(body), doctest::Contains("must be closed"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(pinch.host.mirror_ground(geom), doctest::Contains("must have no body"),
                       InvalidArgument);
  const dSpaceID space = dSimpleSpaceCreate(nullptr);
  CHECK_THROWS_WITH_AS(pinch.host.mirror_ground(reinterpret_cast<dGeomID>(space)),
                       doctest::Contains("space"), InvalidArgument);
  dGeomClass mine{};
  mine.collider = [](int) -> dColliderFn* { return nullptr; };
  mine.aabb = dInfiniteAABB;
  const dGeomID odd = dCreateGeom(dCreateGeomClass(&mine));
  CHECK_THROWS_WITH_AS(pinch.host.mirror_ground(odd), doctest::Contains("user"), InvalidArgument);
  CHECK(pinch.host.world().state_hash() == before);
  dGeomDestroy(odd);
  dSpaceDestroy(space);
  dGeomDestroy(geom);
  dGeomTriMeshDataDestroy(mesh);

  pinch.run(0.1);
  CHECK(pinch.reading(0).touching() == 36);
  pinch.host.forget(pinch.part_body);
  pinch.host.forget(pinch.part_body);
  pinch.run(pinch.def.dt);
  CHECK(pinch.reading(0).touching() == 0);
  CHECK(pinch.host.mirror(pinch.part_body) == pinch.host.mirror(pinch.part_body));
}
