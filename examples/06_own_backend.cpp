// A world over geometry of one's own: marbles, in the fifty lines that a backend needs at least.
//
// `ShapeBackend` asks for a prepared form of a shape and seven functions on it. Everything else
// (broad phase, solver, joints, sensors) is the same for every backend. Ours knows spheres only:
// two with radii a and b, whose centres are d apart, touch where d - a - b <= margin, and a ray is
// left to the library's closed form. A marble of 20 mm rests on a fixed ball of 1 m, and a feeler
// of one ray, 10 mm long, finds the marble's top 4 mm away: depth 1 - 4 / 10 = 0.6.
//
// Expected output: 06_own_backend.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

using namespace bristle;

namespace {

struct Marbles {
  /// Copy of each shape that the world keeps: any copyable type.
  template <Scalar S>
  struct Collidable {
    Sphere<S> sphere;
  };

  template <Scalar S>
  static Collidable<S> make(const Shape<S>& shape) {
    validate(shape);
    if (kind_of(shape) != ShapeKind::sphere) {
      throw InvalidArgument("Shape", name_of(kind_of(shape)), "must be a sphere");
    }
    return {std::get<Sphere<S>>(shape)};
  }
  template <Scalar S>
  static ShapeKind kind(const Collidable<S>&) {
    return ShapeKind::sphere;
  }
  template <Scalar S>
  static Aabb<S> bounds(const Collidable<S>& c) {
    return local_bounds<S>(c.sphere);
  }
  template <Scalar S>
  static MassProperties<S> mass_properties(const Collidable<S>& c) {
    return unit_mass_properties<S>(c.sphere);
  }
  static bool can_collide(ShapeKind a, ShapeKind b) {
    return a == ShapeKind::sphere && b == ShapeKind::sphere;
  }
  template <Scalar S>
  static ContactStatus collide(const Collidable<S>& a, const Collidable<S>& b,
                               const Transform<S>& X_AB, S margin,
                               ContactManifolds<S>& out) noexcept {
    const S distance = X_AB.translation.norm();
    const S gap = distance - a.sphere.radius - b.sphere.radius;
    if (gap > margin || !(distance > S(0))) return ContactStatus::ok;  // nothing to report
    ContactManifold<S> manifold;
    manifold.normal = X_AB.translation / distance;
    manifold.add({.position = (a.sphere.radius + gap / S(2)) * manifold.normal, .gap = gap});
    out.push_back(manifold);
    return ContactStatus::ok;
  }
  template <Scalar S>
  static void cast_rays(const Collidable<S>& c, const Transform<S>& X_RC, const RayBatch<S>& rays,
                        std::uint32_t tag, RayHits<S>& hits) noexcept {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      Ray<S> ray = rays[i];
      ray.origin -= X_RC.translation;  // a sphere looks the same from all sides
      hits.offer(i, ray_cast(c.sphere, ray), tag);
    }
  }
};

static_assert(ShapeBackend<Marbles, float> && ShapeBackend<Marbles, double>);

}  // namespace

int main() {
  World<double, Marbles> world;
  world.add_body({.motion = Motion::fixed, .shape = Sphere<double>{.radius = 1}});
  const BodyId marble =
      world.add_body({.shape = Sphere<double>{.radius = 0.02}, .position = {0, 0, 1.05}});
  const BodyId feeler = world.add_body({.motion = Motion::fixed, .position = {0, 0, 1.044}});
  SensorLayout<double> ray;
  ray.add({0, 0, 0}, {0, 0, -0.01});
  const PatchId touch = world.add_patch(feeler, {.sensors = ray});
  for (int i = 0; i < 480; ++i) world.step();

  std::printf("the marble rests at %.3f m; expected 1.020\n", world.pose(marble).translation.z());
  std::printf("depth of the feeler %.2f; expected 0.60\n", world.reading(touch).depth[0]);
  try {
    world.add_body({.shape = Box<double>{.half_extents = {1, 1, 1}}});
  } catch (const InvalidArgument& error) {
    std::printf("a box is refused: %s\n", error.what());
  }
}
