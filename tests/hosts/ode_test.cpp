/// @file
/// The pinch in ODE: held by patches at any step, and let go below Coulomb's limit. What joints
/// leave free, and rays at mirrored shapes, against ODE itself.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/hosts/ode_host.hpp>
#include <bristle/sensors/tuning.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

using namespace bristle;

namespace {

/// ODE, from the first world on until the program ends.
struct OdeLibrary {
  OdeLibrary() { dInitODE2(0); }
  ~OdeLibrary() { dCloseODE(); }
  OdeLibrary(const OdeLibrary&) = delete;
  OdeLibrary& operator=(const OdeLibrary&) = delete;
};

/// A world without gravity whose joints are hard.
struct OdeWorld {
  dWorldID id;
  dSpaceID space;

  OdeWorld() {
    static const OdeLibrary library;
    id = dWorldCreate();
    space = dSimpleSpaceCreate(nullptr);
    dWorldSetCFM(id, 0);
  }
  ~OdeWorld() {
    dSpaceDestroy(space);
    dWorldDestroy(id);
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  [[nodiscard]] dBodyID add_box(double mass, const Vec3<double>& size, const Vec3<double>& place) {
    const dBodyID body = dBodyCreate(id);
    dMass m;
    dMassSetBoxTotal(&m, mass, size.x(), size.y(), size.z());
    dBodySetMass(body, &m);
    dBodySetPosition(body, place.x(), place.y(), place.z());
    dGeomSetBody(dCreateBox(space, size.x(), size.y(), size.z()), body);
    return body;
  }
};

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

Vec3<double> ode_vector(const dReal* x) { return {x[0], x[1], x[2]}; }

Vec6<double> ode_twist(dBodyID body) {
  Vec6<double> twist;
  twist << ode_vector(dBodyGetLinearVel(body)), ode_vector(dBodyGetAngularVel(body));
  return twist;
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

struct OdePinchDef {
  double mass = 0.045;
  double squeeze = 12;
  double offset = 0;
  double dt = 1e-3;
};

/// Two pads on slides and a part between them, without contacts.
struct OdePinch {
  OdePinchDef def;
  OdeWorld ode;
  dBodyID pads[2];
  dBodyID part;
  OdeHost<> host{ode.id};
  PatchId patches[2];

  explicit OdePinch(const OdePinchDef& d) : def(d) {
    const Vec3<double> size(0.01, 0.02, 0.02);
    part = ode.add_box(def.mass, size, {0, def.offset, 0});
    dGeomSetOffsetPosition(dBodyGetFirstGeom(part), 0, -def.offset, 0);
    (void)host.mirror(part);
    GripWants<double> wants;
    wants.friction = 0.7;
    wants.load = def.squeeze;
    wants.mass = def.mass;
    wants.press = 0.45;
    for (int k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      pads[k] = ode.add_box(0.1, size, {-side * 0.0101, 0, 0});
      const dJointID slide = dJointCreateSlider(ode.id, nullptr);
      dJointAttach(slide, pads[k], nullptr);
      dJointSetSliderAxis(slide, 1, 0, 0);
      PatchDef<double> patch;
      for (int i = 0; i < 36; ++i) {
        const double y = 0.003 * (i % 6 - 2.5);
        const double z = 0.003 * (i / 6 - 2.5);
        patch.sensors.add({side * 0.002, y, z}, {side * 0.010, y, z});
      }
      patch.parameters = tuned_for<double>(wants).parameters(patch.sensors);
      patches[k] = host.add_patch(pads[k], patch);
    }
  }
  void squeeze() {
    dBodyAddForce(pads[0], def.squeeze, 0, 0);
    dBodyAddForce(pads[1], -def.squeeze, 0, 0);
  }
  void run(double seconds) {
    const long steps = std::lround(seconds / def.dt);
    for (long i = 0; i < steps; ++i) {
      squeeze();
      host.step(def.dt);
    }
  }
  void fall() { dWorldSetGravity(ode.id, 0, 0, -9.81); }
  [[nodiscard]] Vec3<double> place() const { return ode_vector(dBodyGetPosition(part)); }
  [[nodiscard]] PatchReading<double> felt(int k) { return host.world().reading(patches[k]); }
  [[nodiscard]] double weight() { return -felt(0).wrench.force.z() - felt(1).wrench.force.z(); }
  [[nodiscard]] double expected_sag() {
    const double mu_S = host.world().patch(patches[0]).def.parameters.static_friction;
    return def.mass * 9.81 / (mu_S * (felt(0).total_normal() + felt(1).total_normal()));
  }
};

}  // namespace

TEST_CASE("ODE: the pinch holds at any step, and sags by m g / (mu_S sum F_N)") {
  for (const OdePinchDef& base :
       {OdePinchDef{.mass = 0.045, .squeeze = 12}, OdePinchDef{.mass = 2, .squeeze = 60}}) {
    for (const double dt : {5e-4, 1e-3, 2e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60}) {
      CAPTURE(base.mass);
      CAPTURE(dt);
      OdePinchDef def = base;
      def.dt = dt;
      OdePinch pinch(def);
      pinch.run(0.5);
      const double start = pinch.place().z();
      pinch.fall();
      pinch.run(1.5);
      const double there = pinch.place().z();
      pinch.run(2);
      CHECK(std::abs(pinch.place().z() - there) < 2e-9);
      CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(1e-3));
      CHECK(pinch.weight() == doctest::Approx(def.mass * 9.81).epsilon(1e-9));
    }
  }
}

TEST_CASE("ODE: a part whose centre of mass lies beside the pads does not turn on") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    CAPTURE(dt);
    OdePinch pinch({.squeeze = 30, .offset = 0.04, .dt = dt});
    pinch.run(0.5);
    pinch.fall();
    pinch.run(1.5);
    const Vec3<double> there = pinch.place();
    const Vec3<double> turned = ode_vector(dBodyGetQuaternion(pinch.part) + 1);
    pinch.run(2);
    CHECK((pinch.place() - there).norm() < 2e-9);
    // Half the angle; the centre of mass is 40 mm away.
    CHECK((ode_vector(dBodyGetQuaternion(pinch.part) + 1) - turned).norm() < 2e-9 / 0.04 / 2);
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("ODE: a squeeze below Coulomb's limit lets go, and one above it holds") {
  const double limit = 0.045 * 9.81 / (2 * 0.7);
  for (const double factor : {1.01, 0.99}) {
    CAPTURE(factor);
    OdePinch pinch({});
    pinch.run(0.5);
    pinch.fall();
    pinch.run(0.5);
    for (; pinch.def.squeeze > factor * limit; pinch.def.squeeze *= 0.99) pinch.run(0.01);
    pinch.def.squeeze = factor * limit;
    const double start = pinch.place().z();
    pinch.run(2);
    CHECK((std::abs(pinch.place().z() - start) < 1e-4) == (factor > 1));
    const double there = pinch.place().z();
    pinch.run(1);
    CHECK((std::abs(pinch.place().z() - there) < 2e-9) == (factor > 1));
  }
}

TEST_CASE("ODE: the quick step holds, too, and a part that would fall asleep stays awake") {
  OdePinch pinch({});
  dBodySetAutoDisableFlag(pinch.part, 1);
  pinch.run(0.5);
  pinch.fall();
  const auto run_quickly = [&](double seconds) {
    for (long i = 0; i < std::lround(seconds / pinch.def.dt); ++i) {
      pinch.squeeze();
      pinch.host.sense(pinch.def.dt);
      dWorldQuickStep(pinch.ode.id, pinch.def.dt);
    }
  };
  run_quickly(1.5);
  const double there = pinch.place().z() - dBodyGetPosition(pinch.pads[0])[2];
  run_quickly(2);
  CHECK(std::abs(pinch.place().z() - dBodyGetPosition(pinch.pads[0])[2] - there) < 2e-9);
  CHECK(dBodyIsEnabled(pinch.part) == 1);
  CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-9));
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
      const HostBody<double> before = host.body(id);
      CHECK(host.mobility(base_id, base_id) == Mat6<double>::Zero());
      CHECK(host.body(base_id).acceleration.angular == Vec3<double>::Zero());
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
  OdePinch pinch({});
  const dBodyID far = pinch.ode.add_box(1, {0.01, 0.01, 0.01}, {0, 0, 1});
  (void)pinch.host.mirror(far);
  for (int i = 0; i < 300; ++i) {
    dBodyAddForce(pinch.part, 0, 0.25, 0);
    dBodyAddForce(far, 0, 0.5, 0);
    pinch.squeeze();
    pinch.host.sense(pinch.def.dt);
    CHECK(ode_vector(dBodyGetForce(far)) == Vec3<double>(0, 0.5, 0));
    dWorldStep(pinch.ode.id, pinch.def.dt);
    CHECK(ode_vector(dBodyGetForce(pinch.part)) == Vec3<double>::Zero());
  }
  CHECK(pinch.felt(0).wrench.force.y() + pinch.felt(1).wrench.force.y() ==
        doctest::Approx(0.25).epsilon(1e-3));
}

TEST_CASE("ODE: rays meet mirrored geoms where they meet ODE's") {
  const std::vector<std::function<dGeomID(dSpaceID)>> makers{
      [](dSpaceID space) { return dCreateBox(space, 0.4, 0.6, 0.8); },
      [](dSpaceID space) { return dCreateSphere(space, 0.3); },
      [](dSpaceID space) { return dCreateCapsule(space, 0.2, 0.5); },
      [](dSpaceID space) { return dCreateCylinder(space, 0.25, 0.8); },
      [](dSpaceID space) { return dCreatePlane(space, 0.6, 2, 8, 1.2); }};
  const dGeomID ray = dCreateRay(nullptr, 10);
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
        const WorldRayHit<double> hit = host.world().cast_ray({from, along, 10});
        dContactGeom contact;
        const bool is_hit = dCollide(ray, geom, 1, &contact, sizeof(contact)) > 0;
        // ODE meets planes from behind, too; there a ray starts inside of what is mirrored.
        if (hit.distance == 0) continue;
        CHECK(hit.is_hit() == is_hit);
        if (!hit.is_hit() || !is_hit) continue;
        ++hits;
        CHECK(hit.distance == doctest::Approx(contact.depth).epsilon(1e-9));
        CHECK((hit.normal - ode_vector(contact.normal)).norm() < 1e-7);
      }
      CHECK(hits > 40);
      CHECK(hits < 200);
    }
  }
  dGeomDestroy(ray);
}

TEST_CASE("ODE: geoms without a shape like them are refused by name, and a body is let go") {
  OdePinch pinch({});
  const dReal corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const dTriIndex triangle[] = {0, 1, 2};
  const dTriMeshDataID mesh = dGeomTriMeshDataCreate();
  dGeomTriMeshDataBuildDouble(mesh, corners, 3 * sizeof(dReal), 3, triangle, 3,
                              3 * sizeof(dTriIndex));
  const dGeomID geom = dCreateTriMesh(pinch.ode.space, mesh, nullptr, nullptr, nullptr);
  const dBodyID body = dBodyCreate(pinch.ode.id);
  const std::uint64_t before = pinch.host.world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host.mirror_ground(geom), doctest::Contains("trimesh"),
                       InvalidArgument);
  dGeomSetBody(geom, body);
  CHECK_THROWS_WITH_AS(pinch.host.mirror(body), doctest::Contains("trimesh"), InvalidArgument);
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
  CHECK(pinch.felt(0).touching() == 36);
  pinch.host.forget(pinch.part);
  pinch.host.forget(pinch.part);
  pinch.run(pinch.def.dt);
  CHECK(pinch.felt(0).touching() == 0);
  CHECK(pinch.host.mirror(pinch.part) == pinch.host.mirror(pinch.part));
}
