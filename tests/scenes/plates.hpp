/// @file
/// Fast bodies in front of a thin plate, at 60 Hz.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>

namespace bristle::scenes {

using namespace bristle::detail;

/// [m] Half the thickness of the plate: 1 cm in all.
inline constexpr double plate_half_thickness = 0.005;

/// A plate of 4 x 4 m around the origin, facing up and down.
template <Scalar S>
[[nodiscard]] Shape<S> thin_plate(bool is_mesh) {
  const Vec3<S> half(S(2), S(2), S(plate_half_thickness));
  if (is_mesh) return box_mesh<S>(half);
  return Box<S>{half};
}

/// Course of a body that flew at a plate.
struct Flight {
  /// [m] Least height of its middle above the plate's, at any step.
  double lowest_middle = 1e300;
  /// [m] Least height of its lowest point above the plate's upper side: at any step, and at the
  /// end.
  double lowest_clearance = 1e300;
  double last_clearance = 1e300;
  /// [-] Most contacts in a step.
  std::size_t contacts = 0;
};

/// [m] Height of the lowest point of a convex shape.
template <Scalar S, typename ConvexShape>
[[nodiscard]] double lowest_point(const ConvexShape& shape, const Transform<S>& X) {
  const Vec3<S> down = X.rotation.conjugate() * Vec3<S>(-Vec3<S>::UnitZ());
  return static_cast<double>((X * support_point(shape, down)).z());
}

/// Lets `body`, whose shape is `shape`, fly for a while.
template <typename Backend, Scalar S, typename ConvexShape>
[[nodiscard]] Flight fly_at_plate(const ConvexShape& shape, BodyDef<S> body, bool is_mesh,
                                  int steps) {
  WorldDef<S> def;
  def.time_step = S(1) / S(60);
  World<S, Backend> world(def);
  BodyDef<S> plate;
  plate.motion = Motion::fixed;
  plate.shape = thin_plate<S>(is_mesh);
  world.add_body(plate);
  body.shape = shape;
  const BodyId id = world.add_body(body);
  Flight flight;
  for (int i = 0; i < steps; ++i) {
    world.step();
    const Transform<S> X = world.pose(id);
    flight.lowest_middle = std::min(flight.lowest_middle, static_cast<double>(X.translation.z()));
    flight.last_clearance = lowest_point(shape, X) - plate_half_thickness;
    flight.lowest_clearance = std::min(flight.lowest_clearance, flight.last_clearance);
    flight.contacts = std::max(flight.contacts, world.report().contact_points);
  }
  return flight;
}

/// A ball of 5 cm at 100 m/s, which flies 33 times its size in a step of 1/60 s.
/// @param height, aside  [m] where it starts; [m/s] sideways.
template <typename Backend>
void check_fast_ball(bool is_mesh, double height, double aside) {
  CAPTURE(height);
  CAPTURE(aside);
  BodyDef<double> body;
  body.position = {-0.3, 0.17, height};
  body.velocity = {aside, 0, -100};
  body.gravity_scale = 0;
  // Aslant it may leave over the plate's edge, 2.3 m away, after two steps.
  const int steps = aside > 0 ? 2 : 30;
  const Flight flight = fly_at_plate<Backend>(Sphere<double>{0.025}, body, is_mesh, steps);
  // A contact ends at its gap, to what the solver leaves: 1e-9 of the way of a step.
  CHECK(flight.lowest_clearance > -1e-8);
}

/// A rod of 1 m that spins at 100 rad/s while it falls on the plate.
///
/// Its ends move at 50 m/s and it turns by 1.7 rad in a step, while contacts are linear in the
/// step. So an end may dip into the plate; but no rod gets to its other side, and what dips in
/// comes out.
template <typename Backend, typename ConvexShape>
void check_spinning_rod(const ConvexShape& shape, bool is_mesh, int round) {
  BodyDef<double> body;
  body.position = {0, 0, 0.6 + 0.07 * round};
  body.orientation = exp_rotation<double>({0.4 * round, 0.3, 0});
  body.velocity = {0, 0, -5};
  body.angular_velocity = {100, 0, 0};
  body.mass = 1;
  // Else it drives off the plate.
  body.material.friction = 0;
  const Flight flight = fly_at_plate<Backend>(shape, body, is_mesh, 90);
  CHECK(flight.contacts > 0);
  CHECK(flight.lowest_middle > 0);
  CHECK(flight.last_clearance > -1e-4);
}

}  // namespace bristle::scenes
