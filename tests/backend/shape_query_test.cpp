/// @file
/// Tests of what a world can be asked with shapes: closed forms, certificates that need no other
/// search, and worlds of one shape against a world of all.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/backends.hpp"
#include "support/random.hpp"

#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

using namespace bristle;

namespace {

// [m] Scenes are some metres wide. Poses in float are right to 3e-7 m there, and a cast stops short
// by at most 1.5e-8 of its size in either scalar.
template <typename S>
constexpr S allowed_error = std::is_same_v<S, float> ? S(2e-6) : S(5e-8);

template <typename S>
std::vector<Shape<S>> convex_shapes() {
  const std::vector<Vec3<S>> corners{{S(0.4), S(0), S(-0.2)},
                                     {S(-0.3), S(0.3), S(-0.2)},
                                     {S(-0.2), S(-0.4), S(-0.1)},
                                     {S(0), S(0.1), S(0.5)},
                                     {S(0.2), S(0.3), S(0.1)}};
  return {Sphere<S>{S(0.3)},          Box<S>{{S(0.2), S(0.3), S(0.4)}},
          Capsule<S>{S(0.2), S(0.3)}, Cylinder<S>{S(0.25), S(0.3)},
          Cone<S>{S(0.3), S(0.35)},   Ellipsoid<S>{{S(0.2), S(0.3), S(0.45)}},
          convex_hull<S>(corners)};
}

template <typename S>
std::vector<Shape<S>> all_shapes() {
  std::vector<Shape<S>> shapes = convex_shapes<S>();
  shapes.push_back(box_mesh<S>({S(0.3), S(0.2), S(0.25)}));
  return shapes;
}

/// What stands in a scene: a floor and shapes of all kinds at random places above it.
template <typename S>
std::vector<BodyDef<S>> random_bodies(test::Random& random, std::size_t count) {
  std::vector<BodyDef<S>> defs;
  BodyDef<S> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<S>{};
  floor.position = {S(0), S(0), S(-2.6)};
  defs.push_back(floor);
  const std::vector<Shape<S>> shapes = all_shapes<S>();
  for (std::size_t i = 0; i < count; ++i) {
    BodyDef<S> def;
    def.motion = Motion::fixed;
    def.shape = shapes[i % shapes.size()];
    const Transform<S> pose = random.template pose<S>(S(2));
    def.position = pose.translation;
    def.orientation = pose.rotation;
    defs.push_back(def);
  }
  return defs;
}

template <typename World, typename S>
World world_of(const std::vector<BodyDef<S>>& defs) {
  World world;
  for (const BodyDef<S>& def : defs) world.add_body(def);
  return world;
}

/// A world of one shape that stays where it is.
template <typename World, typename S>
World world_of_one(const Shape<S>& shape, const Quat<S>& orientation = Quat<S>::Identity()) {
  BodyDef<S> def;
  def.motion = Motion::fixed;
  def.shape = shape;
  def.orientation = orientation;
  return world_of<World, S>({def});
}

template <typename S>
Transform<S> moved(Transform<S> pose, const Vec3<S>& by) {
  pose.translation += by;
  return pose;
}

}  // namespace

TEST_CASE_TEMPLATE("closest: a point before a face, an edge and a corner of a box, and a floor",
                   Setup, BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  World<S, typename Setup::Backend> world;
  const BodyId box = world.add_body({.shape = Box<S>{{S(1), S(2), S(3)}}});
  const auto check = [&](const Vec3<S>& point, const Vec3<S>& on_box) {
    const WorldHit<S> hit = world.closest(point, S(10));
    REQUIRE(hit.is_hit());
    CHECK(hit.body == box);
    CHECK(std::abs(hit.distance - (point - on_box).norm()) < allowed_error<S>);
    CHECK((hit.point - on_box).norm() < S(2) * allowed_error<S>);
    CHECK((hit.normal - (point - on_box).normalized()).norm() < S(4) * allowed_error<S>);
  };
  check({S(1.5), S(0.3), S(-2)}, {S(1), S(0.3), S(-2)});
  check({S(1.5), S(2.5), S(0.7)}, {S(1), S(2), S(0.7)});
  check({S(-1.5), S(2.5), S(-4)}, {S(-1), S(2), S(-3)});
  CHECK_FALSE(world.closest(Vec3<S>(S(1.5), S(0), S(0)), S(0.4)).is_hit());
  CHECK(world.closest(Vec3<S>(S(1.5), S(0), S(0)), S(0.5)).is_hit());

  const BodyId floor = world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<S>{}, .position = {S(0), S(0), S(-5)}});
  const WorldHit<S> below = world.closest(Vec3<S>(S(9), S(8), S(-4.5)), infinity<S>);
  CHECK(below.body == floor);
  CHECK((below.point - Vec3<S>(S(9), S(8), S(-5))).norm() < S(2) * allowed_error<S>);
  const WorldHit<S> inside = world.closest(Vec3<S>(S(0.5), S(0), S(0)), S(1));
  CHECK(inside.distance == S(0));
  CHECK(inside.normal == Vec3<S>(Vec3<S>::Zero()));
}

TEST_CASE_TEMPLATE("closest: a point that is in a mesh, but touches no triangle, is in it", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  World<S, typename Setup::Backend> world;
  world.add_body({.motion = Motion::fixed, .shape = box_mesh<S>({S(1), S(1), S(1)})});
  CHECK(world.closest(Vec3<S>(S(0.2), S(0), S(0)), S(5)).distance == S(0));
  CHECK(world.overlaps(Sphere<S>{S(0.1)}, Transform<S>{}).size() == 1);
  const WorldHit<S> cast =
      world.cast_shape(Sphere<S>{S(0.1)}, Transform<S>{}, Vec3<S>(S(0), S(3), S(0)));
  CHECK(cast.distance == S(0));
  CHECK((cast.normal - Vec3<S>(S(0), S(-1), S(0))).norm() < allowed_error<S>);
}

TEST_CASE_TEMPLATE("closest: ends where the shapes would just touch, for all pairs of kinds", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  test::Random random(7);
  std::size_t wrong = 0;
  std::size_t apart = 0;
  for (const Shape<S>& target : all_shapes<S>()) {
    for (const Shape<S>& query : convex_shapes<S>()) {
      for (int i = 0; i < 12; ++i) {
        const auto world = world_of_one<World<S, typename Setup::Backend>, S>(
            target, random.template rotation<S>());
        const Transform<S> pose = random.template pose<S>(S(1.2));
        const WorldHit<S> hit = world.closest(query, pose, S(10));
        const bool overlaps = !world.overlaps(query, pose).empty();
        wrong += overlaps != (hit.distance == S(0)) ? 1u : 0u;
        if (overlaps) continue;
        ++apart;
        // A plane of this normal parts them by the distance: so it is no less. Where the query goes
        // that far it touches: so it is no more.
        const S less = hit.distance - S(2) * allowed_error<S>;
        const S more = hit.distance + S(2) * allowed_error<S>;
        wrong += !world.overlaps(query, moved(pose, Vec3<S>(-less * hit.normal))).empty() ? 1u : 0u;
        wrong += world.overlaps(query, moved(pose, Vec3<S>(-more * hit.normal))).empty() ? 1u : 0u;
        // The point is on the target, and the query is as far from it.
        const WorldHit<S> back =
            world.closest(Vec3<S>(hit.point + S(0.1) * hit.normal), infinity<S>);
        wrong += std::abs(back.distance - S(0.1)) > S(0.001) ? 1u : 0u;
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(apart > 300);
}

TEST_CASE_TEMPLATE("cast_shape: nothing is in the way before, and it touches there", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  test::Random random(11);
  const auto world = world_of<World<S, typename Setup::Backend>>(random_bodies<S>(random, 24));
  const std::vector<Shape<S>> shapes = convex_shapes<S>();
  std::size_t wrong = 0;
  std::size_t hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape<S>& query = shapes[random.index(shapes.size())];
    const Transform<S> pose = random.template pose<S>(S(3));
    const Vec3<S> way = S(4) * random.template direction<S>();
    const WorldHit<S> hit = world.cast_shape(query, pose, way);
    if (hit.distance == S(0)) {
      wrong += world.overlaps(query, pose).empty() ? 1u : 0u;
      continue;
    }
    const Vec3<S> along = way.normalized();
    const S end = hit.is_hit() ? hit.distance : S(4);
    // A grazing touch is known to the tolerance over the sine of its angle alone.
    const S slope = hit.is_hit() ? -hit.normal.dot(along) : S(1);
    const S slack = S(4) * allowed_error<S> / slope;
    for (const S part : {S(0), S(0.2), S(0.5), S(0.8), S(0.95), S(1)}) {
      const Vec3<S> by = (part * end - slack) * along;
      wrong += part > S(0) && !world.overlaps(query, moved(pose, by)).empty() ? 1u : 0u;
    }
    if (!hit.is_hit()) continue;
    ++hits;
    wrong += slope > S(0) ? 0u : 1u;
    const auto touched = world.overlaps(query, moved(pose, Vec3<S>((end + slack) * along)));
    wrong += std::none_of(touched.begin(), touched.end(),
                          [&](const WorldHit<S>& t) { return t.shape == hit.shape; })
                 ? 1u
                 : 0u;
    // The point lies on what was hit.
    const WorldHit<S> back = world.closest(Vec3<S>(hit.point), S(1));
    wrong += back.distance > S(0.001) ? 1u : 0u;
  }
  CHECK(wrong == 0);
  CHECK(hits > 100);
}

TEST_CASE("closest: no last bit of a pose turns a gap into an overlap") {
  // A simplex that is flat to round-off seems to hold every point of its plane.
  World<double> world;
  world.add_body({.motion = Motion::fixed, .shape = Ellipsoid<double>{{1, 0.7, 1}}});
  test::Random random(3);
  Transform<double> pose;
  pose.rotation = Quat<double>(-0.46890240570283714, -0.15699475793497145, -0.84602916523806482,
                               -0.19929333022328623);
  const Vec3<double> place(2.334029135283652, 0.03110254958491121, 0.82525336704643359);
  std::size_t wrong = 0;
  for (int i = 0; i < 2000; ++i) {
    pose.translation = place + random.in_cube(1e-14);
    const double distance = world.closest(Box<double>{{1, 1, 1}}, pose, 1.0).distance;
    wrong += std::abs(distance - 0.00611370268) > 1e-8 ? 1u : 0u;
  }
  CHECK(wrong == 0);
}

TEST_CASE_TEMPLATE("cast_shape: what a plane parts on the whole way is never touched", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  test::Random random(13);
  std::size_t wrong = 0;
  std::size_t parted = 0;
  for (const Shape<S>& target : all_shapes<S>()) {
    const auto world = world_of_one<World<S, typename Setup::Backend>, S>(target);
    for (const Shape<S>& query : convex_shapes<S>()) {
      for (int i = 0; i < 40; ++i) {
        const Transform<S> pose = random.template pose<S>(S(0.8));
        const WorldHit<S> hit = world.closest(query, pose, S(10));
        if (!(hit.distance > S(1e-3))) continue;
        ++parted;
        const Vec3<S> along = hit.normal.cross(random.template direction<S>()).normalized();
        for (const Vec3<S>& way : {Vec3<S>(S(4) * along), Vec3<S>(S(4) * (along + hit.normal))}) {
          const Vec3<S> back = pose.translation - S(0.5) * way;
          wrong += world.cast_shape(query, {pose.rotation, back}, way).is_hit() &&
                           way.dot(hit.normal) < S(1e-3)
                       ? 1u
                       : 0u;
          wrong += world.cast_shape(query, pose, way).is_hit() ? 1u : 0u;
        }
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(parted > 800);
}

TEST_CASE_TEMPLATE("cast_shape: from where it touched it slides along and leaves freely", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  test::Random random(17);
  std::size_t wrong = 0;
  for (const Shape<S>& target : {Shape<S>(HalfSpace<S>{}), Shape<S>(Box<S>{{S(5), S(5), S(1)}}),
                                 Shape<S>(box_mesh<S>({S(5), S(5), S(1)}))}) {
    // Turned, so that no direction along the face is so to the last bit.
    const Quat<S> turn = random.template rotation<S>();
    const auto world = world_of_one<World<S, typename Setup::Backend>, S>(target, turn);
    const auto turned = [&](S x, S y, S z) { return Vec3<S>(turn * Vec3<S>(x, y, z)); };
    for (const Shape<S>& query : {Shape<S>(Sphere<S>{S(0.5)}), Shape<S>(Capsule<S>{S(0.2), S(0.3)}),
                                  Shape<S>(Box<S>{{S(0.5), S(0.5), S(0.5)}})}) {
      for (int i = 0; i < 50; ++i) {
        Transform<S> pose;
        pose.rotation = turn;
        pose.translation = turned(random.uniform(S(-1), S(1)), random.uniform(S(-1), S(1)),
                                  random.uniform(S(2.5), S(3)));
        const auto is_under = [&](const WorldHit<S>& hit) {
          return (hit.point - pose.translation).cross(turned(0, 0, 1)).norm() <= S(0.75);
        };
        const WorldHit<S> down = world.cast_shape(query, pose, turned(0, 0, -9));
        wrong += down.is_hit() && down.normal.dot(turned(0, 0, 1)) > S(0.999) ? 0u : 1u;
        // The point lies on the target, under the query.
        wrong += is_under(down) ? 0u : 1u;
        pose.translation -= down.distance * turned(0, 0, 1);
        wrong += world.cast_shape(query, pose, turned(0, 0, 5)).is_hit() ? 1u : 0u;
        wrong += world.cast_shape(query, pose, turned(3, 1, 0)).is_hit() ? 1u : 0u;
        const WorldHit<S> again = world.cast_shape(query, pose, turned(0, 0, -1));
        wrong += again.is_hit() && again.distance < S(2) * allowed_error<S> ? 0u : 1u;
        wrong += is_under(again) ? 0u : 1u;
      }
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE_TEMPLATE("closest: the point is under a small box at the rim of a cap", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  World<S, typename Setup::Backend> world;
  world.add_body({.motion = Motion::fixed, .shape = Cylinder<S>{S(1), S(0.5)}});
  std::size_t wrong = 0;
  for (int i = 0; i < 360; ++i) {
    const S angle = S(i) * S(0.0174533);
    Transform<S> pose;
    pose.translation = {S(0.98) * std::cos(angle), S(0.98) * std::sin(angle), S(0.7)};
    const WorldHit<S> hit = world.closest(Box<S>{{S(0.005), S(0.005), S(0.1)}}, pose, S(1));
    const Vec3<S> beside = hit.point - pose.translation;
    wrong += std::max(std::abs(beside.x()), std::abs(beside.y())) > S(0.005) + allowed_error<S> ||
                     std::abs(hit.distance - S(0.1)) > allowed_error<S>
                 ? 1u
                 : 0u;
  }
  CHECK(wrong == 0);
}

TEST_CASE_TEMPLATE("cast_shape: a rotation that is one to rounding turns nothing else", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  World<S, typename Setup::Backend> world;
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  Transform<S> pose;
  pose.translation = {S(0), S(0), S(500)};
  const S distance = world.cast_shape(Sphere<S>{S(0.5)}, pose, {S(0), S(0), S(-600)}).distance;
  pose.rotation = Quat<S>(S(0), S(1) + (std::is_same_v<S, float> ? S(2e-7) : S(5e-9)), S(0), S(0));
  CHECK(std::abs(world.cast_shape(Sphere<S>{S(0.5)}, pose, {S(0), S(0), S(-600)}).distance -
                 distance) < S(500) * allowed_error<S>);
  CHECK(std::abs(distance - S(499.5)) < S(500) * allowed_error<S>);
}

TEST_CASE_TEMPLATE("queries: a world of many answers as the best of worlds of one", Setup,
                   BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  using OneWorld = World<S, typename Setup::Backend>;
  test::Random random(5);
  const std::vector<BodyDef<S>> defs = random_bodies<S>(random, 40);
  const auto world = world_of<OneWorld>(defs);
  std::vector<OneWorld> each;
  for (const BodyDef<S>& def : defs) each.push_back(world_of<OneWorld, S>({def}));
  const std::vector<Shape<S>> shapes = convex_shapes<S>();
  std::size_t wrong = 0;
  std::size_t found = 0;
  for (int i = 0; i < 150; ++i) {
    const Shape<S>& query = shapes[random.index(shapes.size())];
    const Transform<S> pose = random.template pose<S>(S(3));
    const Vec3<S> way = S(3) * random.template direction<S>();
    const Ray<S> ray{pose.translation, Vec3<S>(way.normalized()), S(6)};
    S nearest = infinity<S>;
    S first = infinity<S>;
    std::size_t overlapping = 0;
    std::vector<S> through;
    for (const OneWorld& one : each) {
      nearest = std::min(nearest, one.closest(query, pose, S(1)).distance);
      first = std::min(first, one.cast_shape(query, pose, way).distance);
      overlapping += one.overlaps(query, pose).size();
      const WorldHit<S> hit = one.cast_ray(ray);
      if (hit.is_hit()) through.push_back(hit.distance);
    }
    std::sort(through.begin(), through.end());
    wrong += world.closest(query, pose, S(1)).distance == nearest ? 0u : 1u;
    wrong += world.cast_shape(query, pose, way).distance == first ? 0u : 1u;
    wrong += world.overlaps(query, pose).size() == overlapping ? 0u : 1u;
    const auto hits = world.cast_ray_through(ray);
    wrong += std::equal(hits.begin(), hits.end(), through.begin(), through.end(),
                        [](const WorldHit<S>& a, S b) { return a.distance == b; })
                 ? 0u
                 : 1u;
    found += overlapping + through.size();
  }
  CHECK(wrong == 0);
  CHECK(found > 100);
}

TEST_CASE_TEMPLATE("queries: what a filter leaves out is not there, and equals go to the first",
                   Setup, BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  World<S, typename Setup::Backend> world;
  std::vector<BodyId> balls;
  for (const S x : {S(-2), S(2), S(5)}) {
    balls.push_back(world.add_body(
        {.motion = Motion::fixed, .shape = Sphere<S>{S(0.5)}, .position = {x, S(0), S(0)}}));
  }
  const Vec3<S> middle = Vec3<S>::Zero();
  CHECK(world.closest(middle, S(9)).body == balls[0]);
  CHECK(world.closest(middle, S(9), {.excluded = {balls[0]}}).body == balls[1]);
  const Box<S> box{{S(0.1), S(0.1), S(0.1)}};
  const Vec3<S> way(S(9), S(0), S(0));
  CHECK(world.cast_shape(box, Transform<S>{}, way).body == balls[1]);
  CHECK(world.cast_shape(box, Transform<S>{}, way, {.excluded = {balls[1]}}).body == balls[2]);
  CHECK_FALSE(world.cast_shape(box, Transform<S>{}, way, {.sense_mask = 0}).is_hit());
  CHECK(world.overlaps(Sphere<S>{S(1.5)}, Transform<S>{}).size() == 2);
  CHECK(world.overlaps(Sphere<S>{S(1.5)}, Transform<S>{}, {.excluded = {balls[1]}}).size() == 1);
  const Ray<S> ray{Vec3<S>(S(-9), S(0), S(0)), Vec3<S>(Vec3<S>::UnitX()), S(20)};
  CHECK(world.cast_ray_through(ray, {.excluded = {balls[1]}}).size() == 2);
}

TEST_CASE_TEMPLATE("queries: refuse what they cannot ask with", Setup, BRISTLE_TEST_SETUPS) {
  using S = typename Setup::Scalar;
  const World<S, typename Setup::Backend> world;
  const Transform<S> here;
  const S none = std::numeric_limits<S>::quiet_NaN();
  const Sphere<S> ball{S(1)};
  CHECK_THROWS_AS((void)world.overlaps(HalfSpace<S>{}, here), InvalidArgument);
  CHECK_THROWS_AS((void)world.overlaps(box_mesh<S>({S(1), S(1), S(1)}), here), InvalidArgument);
  CHECK_THROWS_AS((void)world.overlaps(Sphere<S>{S(0)}, here), InvalidArgument);
  CHECK_THROWS_AS((void)world.overlaps(ball, moved(here, Vec3<S>(none, S(0), S(0)))),
                  InvalidArgument);
  CHECK_THROWS_AS((void)world.closest(ball, here, S(0)), InvalidArgument);
  CHECK_THROWS_AS((void)world.closest(Vec3<S>(none, S(0), S(0)), S(1)), InvalidArgument);
  CHECK_THROWS_AS((void)world.cast_shape(ball, here, Vec3<S>(Vec3<S>::Zero())), InvalidArgument);
  CHECK_THROWS_AS((void)world.cast_shape(ball, here, Vec3<S>(infinity<S>, S(0), S(0))),
                  InvalidArgument);
}
