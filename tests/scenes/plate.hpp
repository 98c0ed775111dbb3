/// @file
/// The box of the paper's Fig. 7: a flat plate that stands, hangs or slides on the sensors below
/// it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <cmath>

namespace bristle::scenes {

/// Tilted part of an incline. Both are physically the same; the arithmetic differs.
enum class InclineBy {
  /// Gravity, towards +x; the surface stays in z = 0.
  gravity,
  /// The surface and everything on it, about y, down towards +x.
  surface
};

/// The plate scene. Defaults: Fig. 7 with 16 sensors, no hard contact.
template <Scalar S>
struct PlateDef {
  /// [-] Sensors along each side, on a cell-centred grid.
  int per_side = 4;
  /// [rad] Angle of the incline.
  S incline = S(0);
  /// [-] Tilted part.
  InclineBy incline_by = InclineBy::gravity;
  /// [s] Step.
  S time_step = S(1e-3);
  /// [-] How the patch integrates.
  Integration integration = Integration::implicit;
  S explicit_below = PatchDef<S>{}.explicit_below;
  /// [-] Constants of the sensors.
  SensorParameters<S> parameters{S(1), S(0.05), S(5000), S(0.1), S(1e-3)};
  /// [-] Readings of the law: the paper's, which the reference values are for.
  LawOptions options{.normal = NormalDirection::ray};
  /// [kg] Mass.
  S mass = S(0.5);
  /// [m] Half the height of the plate; its sides are 0.2 m.
  S half_height = S(0.005);
  /// [1] Factor on the inertia. Large: a plate that does not tilt.
  S inertia_factor = S(1);
  /// [rad] Angle of the rays from straight down, towards +x.
  S ray_angle = S(0);
  /// [-] True if the plate also touches the plane by hard contact, without friction.
  bool has_contact = false;
  /// [m] Height above rest at the start.
  S drop = S(0);
  /// [m] Where the scene is in the world.
  Vec3<S> origin = Vec3<S>::Zero();
  /// [1] Unit of length: multiplies every length, and forces with it, so that motion scales too.
  S scale = S(1);
  /// [m/s^2] Gravity, before scaling.
  S gravity = S(9.81);
};

/// The built scene.
template <Scalar S, typename Backend = AnalyticBackend>
struct PlateScene {
  PlateDef<S> def;
  World<S, Backend> world;
  BodyId plane{};
  BodyId plate{};
  PatchId patch{};
  /// [1] Pose of the incline's frame: x down the incline, z out of it.
  Transform<S> X_WI{};

  /// Pose of the plate on its incline, in units of the unscaled scene's lengths.
  [[nodiscard]] Vec3<S> position() const {
    return (X_WI.inverse() * world.body(plate).center_pose.translation) / def.scale;
  }
  /// [m/s] Velocity of the plate along the axes of the incline, of the unscaled scene.
  [[nodiscard]] Vec3<S> velocity() const {
    return X_WI.inverse().rotate(world.body(plate).twist.linear) / def.scale;
  }
  /// [N] Weight in the unscaled scene.
  [[nodiscard]] S weight() const { return def.mass * def.gravity; }
  [[nodiscard]] S sensors() const { return S(def.per_side * def.per_side); }

  /// Pushes the plate during the next step by a force (of the unscaled scene) at its centre of
  /// mass.
  void push_at_center(const Vec3<S>& force) {
    world.apply_wrench(plate, {X_WI.rotate(force) * def.scale, Vec3<S>::Zero()});
  }
  /// The same at the height of the plane, below the centre: a force that does not tilt the plate.
  void push_at_plane(const Vec3<S>& force) {
    const Vec3<S> center = position();
    const Vec3<S> foot = X_WI * Vec3<S>(def.scale * Vec3<S>(center.x(), center.y(), S(0)));
    world.apply_force(plate, X_WI.rotate(force) * def.scale, foot);
  }
  void run(S seconds) {
    const long steps = std::lround(static_cast<double>(seconds / def.time_step));
    for (long i = 0; i < steps; ++i) world.step();
  }
};

/// [1] Depth of the sensors when they carry the plate alone.
template <Scalar S>
[[nodiscard]] S plate_rest_depth(const PlateDef<S>& def) {
  using std::cos;
  return def.mass * def.gravity * cos(def.incline) /
         (S(def.per_side * def.per_side) * def.parameters.normal_stiffness);
}

/// [m] Length of each ray; half of it lies inside the plate.
template <Scalar S>
inline constexpr S plate_ray = S(0.01);

/// [m] Shift of the centre of mass down the incline, at rest on the sensors alone: the bristles'
/// stretch, plus what the plate's tilt on its springs moves its centre at height h,
/// m g sin(angle) h^2 / sum (K_N / L) x_i^2.
template <Scalar S>
[[nodiscard]] S plate_rest_shift(const PlateDef<S>& def) {
  using std::sin;
  using std::tan;
  const S n = S(def.per_side * def.per_side);
  const S ray = plate_ray<S>;
  const S h = def.half_height - ray / S(2) + ray * (S(1) - plate_rest_depth(def));
  // Mean of x^2 on a cell-centred grid of N points over 0.2 m: (0.1^2 / 3) (1 - 1 / N^2).
  const S mean_x2 = S(0.01) / S(3) * (S(1) - S(1) / n);
  const S tilt_stiffness = def.parameters.normal_stiffness / ray * n * mean_x2;
  return tan(def.incline) / def.parameters.static_friction +
         def.mass * def.gravity * sin(def.incline) * h * h / tilt_stiffness;
}

/// Builds the scene, at rest in height unless a drop is asked for.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] PlateScene<S, Backend> make_plate(const PlateDef<S>& def) {
  using std::cos;
  using std::sin;
  const S unit = def.scale;
  const bool tilts_surface = def.incline_by == InclineBy::surface;
  const S turn = tilts_surface ? def.incline : S(0);
  const Transform<S> X_WI{exp_rotation<S>(turn * Vec3<S>::UnitY()), def.origin};

  WorldDef<S> world_def;
  world_def.time_step = def.time_step;
  world_def.gravity =
      (unit * def.gravity) * (tilts_surface ? Vec3<S>(-Vec3<S>::UnitZ())
                                            : Vec3<S>(sin(def.incline), S(0), -cos(def.incline)));
  PlateScene<S, Backend> scene{def, World<S, Backend>(world_def), {}, {}, {}, X_WI};

  BodyDef<S> plane;
  plane.motion = Motion::fixed;
  plane.shape = HalfSpace<S>{};
  plane.material.friction = S(0);
  plane.filter.mask = def.has_contact ? 0xffffffffu : 0u;
  plane.position = X_WI.translation;
  plane.orientation = X_WI.rotation;
  scene.plane = scene.world.add_body(plane);

  const S h = unit * def.half_height;
  const S side = unit * S(0.1);
  const S ray = unit * plate_ray<S>;
  const S rest = def.has_contact ? h : h - ray / S(2) + ray * (S(1) - plate_rest_depth(def));
  BodyDef<S> plate;
  plate.mass = def.mass;
  plate.shape = Box<S>{{side, side, h}};
  plate.material.friction = S(0);
  const S third = def.inertia_factor * def.mass / S(3);
  const Vec3<S> moments(side * side + h * h, side * side + h * h, S(2) * side * side);
  plate.inertia = Mat3<S>((third * moments).asDiagonal());
  plate.position = X_WI * Vec3<S>(S(0), S(0), rest + unit * def.drop);
  plate.orientation = X_WI.rotation;
  scene.plate = scene.world.add_body(plate);

  PatchDef<S> patch;
  const Vec3<S> direction(sin(def.ray_angle), S(0), -cos(def.ray_angle));
  const S n = S(def.per_side);
  for (int i = 0; i < def.per_side; ++i) {
    for (int j = 0; j < def.per_side; ++j) {
      const S x = side * ((S(2 * i) + S(1)) / n - S(1));
      const S y = side * ((S(2 * j) + S(1)) / n - S(1));
      patch.sensors.add(Vec3<S>(x, y, ray / S(2) - h), direction, ray);
    }
  }
  const SensorParameters<S>& p = def.parameters;
  const bool is_by_force = def.options.scaling == FrictionScaling::normal_force;
  patch.parameters = {p.normal_stiffness * unit, p.normal_damping * unit,
                      is_by_force ? p.static_friction / unit : p.static_friction,
                      p.sliding_friction, p.breakaway_distance * unit};
  patch.options = def.options;
  patch.integration = def.integration;
  patch.explicit_below = def.explicit_below;
  scene.patch = scene.world.add_patch(scene.plate, patch);
  return scene;
}

}  // namespace bristle::scenes
