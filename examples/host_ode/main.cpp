// A part is pinched and lifted in ODE: by ODE's own contacts, and by bristle's sensors.
//
// `host.step(dt)` takes the place of dWorldStep.
// The table says how fast a light part and a heavy one creep out of the pads at steps from 1 to 17
// ms; the plot shows where they are between the pads.
//
// Usage: host_ode [PLOT.svg]
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pinch.hpp"
#include "support/lifted_pinch.hpp"

#include <bristle/bristle.hpp>
#include <bristle/hosts/ode_host.hpp>

#include <array>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <optional>

using namespace bristle;
using namespace figure;

namespace {

class OdePinch {
 public:
  OdePinch(const LiftedPinch& pinch, bool has_sensors) : pinch_(pinch) {
    dWorldSetGravity(world_, 0, 0, -pinch.gravity);
    dBodySetKinematic(lift_);
    for (std::size_t k = 0; k < 2; ++k) {
      const dJointID slide = dJointCreateSlider(world_, nullptr);
      dJointAttach(slide, pads_[k], lift_);
      dJointSetSliderAxis(slide, 1, 0, 0);
    }
    if (!has_sensors) return;
    host_.emplace(world_);
    host_->mirror(part_);
    host_->add_patch(pads_[0], scenes::pinch_pad(1, pinch.spec()));
    host_->add_patch(pads_[1], scenes::pinch_pad(-1, pinch.spec()));
  }
  ~OdePinch() {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  OdePinch(const OdePinch&) = delete;
  OdePinch& operator=(const OdePinch&) = delete;

  void step(double t) {
    dBodySetLinearVel(lift_, 0, 0, pinch_.speed(t));
    dBodyAddForce(pads_[0], pinch_.squeeze, 0, 0);
    dBodyAddForce(pads_[1], -pinch_.squeeze, 0, 0);
    if (host_) {
      host_->step(pinch_.dt);
      return;
    }
    dSpaceCollide(space_, this, [](void* self, dGeomID a, dGeomID b) {
      static_cast<OdePinch*>(self)->touch(a, b);
    });
    // The direct solver of dWorldStep gives up at faces that touch at eight points.
    dWorldQuickStep(world_, pinch_.dt);
    dJointGroupEmpty(contacts_);
  }
  [[nodiscard]] double place() const {
    return dBodyGetPosition(part_)[2] -
           0.5 * (dBodyGetPosition(pads_[0])[2] + dBodyGetPosition(pads_[1])[2]);
  }

 private:
  dBodyID body(double mass, double x) {
    const dBodyID made = dBodyCreate(world_);
    dMass m;
    dMassSetBoxTotal(&m, mass, 0.01, 0.02, 0.02);
    dBodySetMass(made, &m);
    dBodySetPosition(made, x, 0, 0);
    dGeomSetBody(dCreateBox(space_, 0.01, 0.02, 0.02), made);
    return made;
  }
  /// Contacts with Coulomb's cone as ODE has it, a pyramid that follows the normal force.
  void touch(dGeomID a, dGeomID b) {
    std::array<dContactGeom, 8> found;
    const int n =
        dCollide(a, b, static_cast<int>(found.size()), found.data(), sizeof(dContactGeom));
    for (int i = 0; i < n; ++i) {
      dContact contact{};
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = pinch_.friction;
      contact.geom = found[static_cast<std::size_t>(i)];
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), dGeomGetBody(a),
                   dGeomGetBody(b));
    }
  }

  LiftedPinch pinch_;
  dWorldID world_ = dWorldCreate();
  dSpaceID space_ = dSimpleSpaceCreate(nullptr);
  dJointGroupID contacts_ = dJointGroupCreate(0);
  dBodyID lift_ = dBodyCreate(world_);
  dBodyID part_ = body(pinch_.mass, 0);
  std::array<dBodyID, 2> pads_{body(0.1, -0.0101), body(0.1, 0.0101)};
  std::optional<OdeHost<>> host_;
};

}  // namespace

int main(int count, char** arguments) {
  dInitODE2(0);
  int code = 2;
  try {
    code = compare_pinches<OdePinch>("ODE", count > 1 ? arguments[1] : "host_ode.svg", 1e-9);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host_ode: %s\n", error.what());
  }
  dCloseODE();
  return code;
}
