/// @file
/// The pinch in ODE.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/ode_host.hpp>

#include <array>
#include <cstddef>
#include <ode/ode.h>
#include <scenes/pinch.hpp>

namespace bristle::scenes {

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

class OdePinch : public Pinch {
 public:
  explicit OdePinch(const PinchDef& d) : Pinch(d) {
    const Vec3<double> size(0.01, 0.02, 0.02);
    part_body = ode.add_box(def.mass, size, {0, def.offset, 0});
    dGeomSetOffsetPosition(dBodyGetFirstGeom(part_body), 0, -def.offset, 0);
    (void)host.mirror(part_body);
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      pads_[k] = ode.add_box(pad_mass, size, {-side * 0.0101, 0, 0});
      const dJointID slide = dJointCreateSlider(ode.id, nullptr);
      dJointAttach(slide, pads_[k], nullptr);
      dJointSetSliderAxis(slide, 1, 0, 0);
      patches[k] = host.add_patch(pads_[k], pinch_pad(side, def.spec(), def.across));
    }
  }

  ~OdePinch() override { dJointGroupDestroy(contacts_); }
  OdePinch(const OdePinch&) = delete;
  OdePinch& operator=(const OdePinch&) = delete;

  [[nodiscard]] World<double>& world() override { return host.world(); }
  [[nodiscard]] std::size_t missing() override { return host.sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override {
    return detail::ode_vector(dBodyGetPosition(part_body));
  }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    return detail::ode_vector(dBodyGetPosition(pads_[k]));
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? 1 : -1;
      dBodySetPosition(pads_[k], pad(k).x() - side * gap, 0, 0);
      dBodySetLinearVel(pads_[k], side * speed, 0, 0);
    }
  }
  void step() override {
    push();
    if (!def.has_contacts) return host.step(def.dt);
    // ODE's direct solver gives up at faces that touch at several points.
    host.sense(def.dt);
    dWorldQuickStep(ode.id, def.dt);
  }
  /// Applies the forces of the next step, and makes its contacts.
  void push() {
    dJointGroupEmpty(contacts_);
    if (def.has_contacts) {
      dSpaceCollide(ode.space, this, [](void* pinch, dGeomID a, dGeomID b) {
        static_cast<OdePinch*>(pinch)->touch(a, b);
      });
    }
    dBodyAddForce(pads_[0], def.squeeze, 0, 0);
    dBodyAddForce(pads_[1], -def.squeeze, 0, 0);
    dWorldSetGravity(ode.id, gravity.x(), gravity.y(), gravity.z());
  }

  OdeWorld ode;
  dBodyID part_body = nullptr;
  OdeHost<> host{ode.id};

 private:
  void touch(dGeomID a, dGeomID b) {
    std::array<dContact, 8> found{};
    const int count =
        dCollide(a, b, static_cast<int>(found.size()), &found[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      dContact& contact = found[static_cast<std::size_t>(i)];
      contact.surface.mode = dContactApprox1 | dContactSoftCFM;
      contact.surface.mu = def.friction;
      contact.surface.soft_cfm = 1e-5;
      dJointAttach(dJointCreateContact(ode.id, contacts_, &contact), dGeomGetBody(a),
                   dGeomGetBody(b));
    }
  }

  dJointGroupID contacts_ = dJointGroupCreate(0);
  std::array<dBodyID, 2> pads_{};
};

}  // namespace bristle::scenes
