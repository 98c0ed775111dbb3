/// @file
/// The pinch in ODE: held by patches at any step, and let go below Coulomb's limit.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/hosts/ode_host.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>

using namespace bristle;

namespace {

struct OdePinchDef {
  double mass = 0.045;
  double squeeze = 12;
  double offset = 0;
  double dt = 1e-3;
};

struct OdePinch {
  OdePinchDef def;
  dWorldID world;
  dSpaceID space;
  dBodyID pads[2];
  dBodyID part;
  std::unique_ptr<OdeHost<>> host;
  PatchId patches[2];

  explicit OdePinch(const OdePinchDef& d) : def(d) {
    static const int started = dInitODE2(0);
    REQUIRE(started != 0);
    world = dWorldCreate();
    space = dSimpleSpaceCreate(nullptr);
    dWorldSetCFM(world, 0);
    const auto add = [&](double mass, const Vec3<double>& place, double beside) {
      const dBodyID body = dBodyCreate(world);
      dMass inertia;
      dMassSetBoxTotal(&inertia, mass, 0.01, 0.02, 0.02);
      dBodySetMass(body, &inertia);
      dBodySetPosition(body, place.x(), place.y(), place.z());
      const dGeomID box = dCreateBox(space, 0.01, 0.02, 0.02);
      dGeomSetBody(box, body);
      dGeomSetOffsetPosition(box, 0, beside, 0);
      return body;
    };
    for (int k = 0; k < 2; ++k) {
      pads[k] = add(0.1, {k == 0 ? -0.0101 : 0.0101, 0, 0}, 0);
      const dJointID slide = dJointCreateSlider(world, nullptr);
      dJointAttach(slide, pads[k], nullptr);
      dJointSetSliderAxis(slide, 1, 0, 0);
    }
    part = add(def.mass, {0, def.offset, 0}, -def.offset);
    host = std::make_unique<OdeHost<>>(world);
    (void)host->mirror(part);
    GripWants<double> wants;
    wants.friction = 0.7;
    wants.load = def.squeeze;
    wants.mass = def.mass;
    wants.press = 0.45;
    for (int k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      PatchDef<double> patch;
      for (int i = 0; i < 36; ++i) {
        const double y = 0.003 * (i % 6 - 2.5);
        const double z = 0.003 * (i / 6 - 2.5);
        patch.sensors.add({side * 0.002, y, z}, {side * 0.010, y, z});
      }
      patch.parameters = tuned_for<double>(wants).parameters(patch.sensors);
      patches[k] = host->add_patch(pads[k], patch);
    }
  }
  ~OdePinch() {
    dSpaceDestroy(space);
    dWorldDestroy(world);
  }
  OdePinch(const OdePinch&) = delete;
  OdePinch& operator=(const OdePinch&) = delete;

  void set_gravity() { dWorldSetGravity(world, 0, 0, -9.81); }
  void run(double seconds) {
    const long steps = std::lround(seconds / def.dt);
    for (long i = 0; i < steps; ++i) {
      dBodyAddForce(pads[0], def.squeeze, 0, 0);
      dBodyAddForce(pads[1], -def.squeeze, 0, 0);
      host->sense(def.dt);
      dWorldStep(world, def.dt);
    }
  }
  /// [m] Where the part is between the pads.
  [[nodiscard]] double height() const {
    return dBodyGetPosition(part)[2] - dBodyGetPosition(pads[0])[2];
  }
  [[nodiscard]] PatchReading<double> felt(int k) const { return host->world().reading(patches[k]); }
  [[nodiscard]] double weight() const {
    return -felt(0).wrench.force.z() - felt(1).wrench.force.z();
  }
  [[nodiscard]] double expected_sag() const {
    const double mu_S = host->world().patch(patches[0]).def.parameters.static_friction;
    return def.mass * 9.81 / (mu_S * (felt(0).total_normal() + felt(1).total_normal()));
  }
};

/// [m/s, rad/s] Twist of a body.
Vec6<double> ode_twist(dBodyID body) {
  const dReal* v = dBodyGetLinearVel(body);
  const dReal* w = dBodyGetAngularVel(body);
  Vec6<double> twist;
  twist << v[0], v[1], v[2], w[0], w[1], w[2];
  return twist;
}

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
      const double start = pinch.height();
      pinch.set_gravity();
      pinch.run(1.5);
      const double there = pinch.height();
      pinch.run(2);
      CHECK(std::abs(pinch.height() - there) < 2e-9);
      CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(1e-3));
      CHECK(pinch.weight() == doctest::Approx(def.mass * 9.81).epsilon(1e-6));
    }
  }
}

TEST_CASE("ODE: a part whose centre of mass lies beside the pads does not turn on") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    OdePinch pinch({.squeeze = 30, .offset = 0.04, .dt = dt});
    pinch.run(0.5);
    pinch.set_gravity();
    pinch.run(1.5);
    const double there = pinch.height();
    pinch.run(2);
    CHECK(std::abs(pinch.height() - there) < 2e-9);
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-6));
  }
}

TEST_CASE("ODE: a squeeze below Coulomb's limit lets go, and one above it holds") {
  const double limit = 0.045 * 9.81 / (2 * 0.7);
  for (const double factor : {1.01, 0.99}) {
    CAPTURE(factor);
    OdePinch pinch({});
    pinch.run(0.5);
    pinch.set_gravity();
    pinch.run(0.5);
    while (pinch.def.squeeze > factor * limit) {
      pinch.def.squeeze *= 0.99;
      pinch.run(0.01);
    }
    pinch.def.squeeze = factor * limit;
    const double start = pinch.height();
    pinch.run(2);
    CHECK((std::abs(pinch.height() - start) < 1e-4) == (factor > 1));
  }
}

TEST_CASE("ODE: mobility is what a step does with a wrench to a body on a joint") {
  for (const int type : {0, 1, 2, 3, 4}) {
    CAPTURE(type);
    OdePinch pinch({});
    const dBodyID body = pinch.part;
    dBodySetPosition(body, 0.1, 0.2, 0.3);
    dJointID joint = nullptr;
    if (type == 1) {
      joint = dJointCreateSlider(pinch.world, nullptr);
    } else if (type == 2) {
      joint = dJointCreateHinge(pinch.world, nullptr);
    } else if (type == 3) {
      joint = dJointCreateBall(pinch.world, nullptr);
    } else if (type == 4) {
      joint = dJointCreateFixed(pinch.world, nullptr);
    }
    if (joint != nullptr) dJointAttach(joint, body, nullptr);
    if (type == 1) dJointSetSliderAxis(joint, 0.6, 0, 0.8);
    if (type == 2) {
      dJointSetHingeAnchor(joint, 0.1, 0.25, 0.33);
      dJointSetHingeAxis(joint, 0.6, 0, 0.8);
    }
    if (type == 3) dJointSetBallAnchor(joint, 0.1, 0.25, 0.33);
    if (type == 4) dJointSetFixed(joint);
    const BodyId id = pinch.host->mirror(body);
    const Wrench<double> wrench{{0.3, -0.2, 0.5}, {0.001, 0.002, -0.003}};
    Vec6<double> impulse;
    impulse << pinch.def.dt * wrench.force, pinch.def.dt * wrench.torque;
    const Vec6<double> expected = pinch.host->mobility(id, id) * impulse;
    pinch.host->apply_wrench(id, wrench);
    dWorldStep(pinch.world, pinch.def.dt);
    CHECK((ode_twist(body) - expected).norm() < 1e-9 + 1e-9 * expected.norm());
    CHECK((expected.norm() > 1e-4) == (type != 4));
  }
}

TEST_CASE("ODE: rays meet mirrored geoms where they meet ODE's") {
  OdePinch pinch({});
  const dGeomID geoms[] = {dCreateBox(pinch.space, 0.4, 0.6, 0.8), dCreateSphere(pinch.space, 0.3),
                           dCreateCapsule(pinch.space, 0.2, 0.5),
                           dCreateCylinder(pinch.space, 0.25, 0.8),
                           dCreatePlane(pinch.space, 0.6, 0, 0.8, -0.3)};
  for (const dGeomID geom : geoms) {
    const int kind = dGeomGetClass(geom);
    CAPTURE(kind);
    OdeHost<> host(pinch.world);
    if (kind != dPlaneClass) {
      const dQuaternion q{0.8, 0, 0.36, 0.48};
      dGeomSetPosition(geom, 0.1, 0, 0.2);
      dGeomSetQuaternion(geom, q);
    }
    (void)host.mirror_ground(geom);
    const dGeomID ray = dCreateRay(nullptr, 10);
    int hits = 0;
    for (int i = 0; i < 60; ++i) {
      const double angle = 2.4 * i;
      const Vec3<double> from(2 * std::cos(angle), 2 * std::sin(angle), 2 + 0.02 * i);
      const Vec3<double> way = (Vec3<double>(0.1, 0.003 * i, 0.1 + 0.004 * i) - from).normalized();
      dGeomRaySet(ray, from.x(), from.y(), from.z(), way.x(), way.y(), way.z());
      dContactGeom contact;
      const bool is_hit = dCollide(ray, geom, 1, &contact, sizeof contact) > 0;
      const WorldRayHit<double> hit = host.world().cast_ray({from, way, 10});
      CHECK(hit.is_hit() == is_hit);
      if (!is_hit) continue;
      ++hits;
      CHECK(hit.distance == doctest::Approx(contact.depth).epsilon(1e-9));
    }
    CHECK(hits > 30);
    dGeomDestroy(ray);
  }
}

TEST_CASE("ODE: forces of the caller stay, and what has no shape like it is refused") {
  OdePinch pinch({});
  pinch.run(0.3);
  for (int i = 0; i < 2000; ++i) {
    dBodyAddForce(pinch.part, 0, 0.25, 0);
    pinch.run(pinch.def.dt);
  }
  CHECK(pinch.felt(0).wrench.force.y() + pinch.felt(1).wrench.force.y() ==
        doctest::Approx(0.25).epsilon(1e-6));
  const dGeomID ray = dCreateRay(pinch.space, 1);
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror_ground(ray), doctest::Contains("dGeomGetClass"),
                       InvalidArgument);
  CHECK(pinch.host->world().state_hash() == before);
}
