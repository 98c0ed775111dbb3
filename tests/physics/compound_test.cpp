/// @file
/// Bodies made of several shapes: what they weigh, and that they stand on all of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

using namespace bristle;
using std::numbers::pi;

namespace {

/// [kg, kg m^2] Box of some density with its centre at `center`, about the origin of the frame.
struct BoxSolid {
  double mass;
  Vec3<double> center;
  Mat3<double> inertia;  // About its own centre.
};

BoxSolid box_solid(const Vec3<double>& half, const Vec3<double>& center, double density) {
  const Vec3<double> a = 2 * half;
  const double m = density * a.prod();
  const Vec3<double> moments(a.y() * a.y() + a.z() * a.z(), a.x() * a.x() + a.z() * a.z(),
                             a.x() * a.x() + a.y() * a.y());
  return {m, center, (m / 12 * moments).asDiagonal()};
}

ShapeDef<double> at(const Shape<double>& shape, const Vec3<double>& p) {
  ShapeDef<double> def;
  def.shape = shape;
  def.X_BS.translation = p;
  return def;
}

}  // namespace

TEST_CASE_TEMPLATE("compound: a dumbbell of two spheres", S, float, double) {
  const S r = S(0.1), d = S(0.3), density = S(800);
  BodyDef<S> def;
  def.density = density;
  for (const S side : {S(-1), S(1)}) {
    ShapeDef<S> ball;
    ball.shape = Sphere<S>{r};
    ball.X_BS.translation = {side * d + S(0.5), S(0), S(0.2)};
    def.shapes.push_back(ball);
  }
  World<S> world;
  const Body<S> body = world.body(world.add_body(def));
  const S m = density * S(4.0 / 3 * pi) * r * r * r;
  const S round_off = S(10) * std::numeric_limits<S>::epsilon();
  CHECK(std::abs(body.mass - 2 * m) <= round_off * m);
  CHECK((body.center_B - Vec3<S>(S(0.5), 0, S(0.2))).norm() <= round_off);
  const S along = S(2) * S(0.4) * m * r * r;
  const S across = along + S(2) * m * d * d;
  const Mat3<S> expected = Vec3<S>(along, across, across).asDiagonal();
  CHECK((body.inertia_B - expected).cwiseAbs().maxCoeff() <= round_off * across);
}

TEST_CASE("compound: an L of two boxes is a box without its corner") {
  const double density = 500;
  // 0.4 x 0.6 x 0.2 in all, without 0.3 x 0.4 x 0.2 at the upper right. The foot is given lying on
  // its side, so that turned shapes count, too.
  const BoxSolid all = box_solid({0.2, 0.3, 0.1}, {0.2, 0.3, 0}, density);
  const BoxSolid corner = box_solid({0.15, 0.2, 0.1}, {0.25, 0.4, 0}, density);
  const double mass = all.mass - corner.mass;
  const Vec3<double> center = (all.mass * all.center - corner.mass * corner.center) / mass;
  const Mat3<double> inertia = all.inertia + point_inertia<double>(all.mass, all.center - center) -
                               corner.inertia -
                               point_inertia<double>(corner.mass, corner.center - center);
  BodyDef<double> def;
  def.density = density;
  def.shapes.push_back(at(Box<double>{{0.05, 0.3, 0.1}}, {0.05, 0.3, 0}));
  ShapeDef<double> foot = at(Box<double>{{0.1, 0.15, 0.1}}, {0.25, 0.1, 0});
  foot.X_BS.rotation = exp_rotation<double>({0, 0, pi / 2});
  def.shapes.push_back(foot);
  World<double> world;
  const Body<double> body = world.body(world.add_body(def));
  CHECK(body.mass == test::relative(mass).epsilon(1e-14));
  CHECK((body.center_B - center).norm() < 1e-14);
  CHECK((body.inertia_B - inertia).cwiseAbs().maxCoeff() < 1e-14 * inertia.norm());
  // The products of inertia are what makes it an L.
  CHECK(std::abs(body.inertia_B(0, 1)) > 0.05 * inertia.norm());
}

TEST_CASE("compound: `shape` counts with `shapes`, and what overlaps counts twice") {
  World<double> world;
  BodyDef<double> def;
  def.shape = Sphere<double>{0.1};
  const double one = world.body(world.add_body(def)).mass;
  def.position = {1, 0, 0};
  def.shapes.push_back(at(Sphere<double>{0.1}, {0, 0, 0}));
  const Body<double> twice = world.body(world.add_body(def));
  CHECK(twice.mass == test::relative(2 * one).epsilon(1e-14));
  CHECK(twice.inertia_B(0, 0) == test::relative(0.4 * 2 * one * 0.01).epsilon(1e-14));
  // Values that are set stay; the rest is scaled and moved.
  def.position = {2, 0, 0};
  def.mass = 3;
  def.center_of_mass = Vec3<double>(0, 0, 0.02);
  const Body<double> set = world.body(world.add_body(def));
  CHECK(set.mass == 3);
  CHECK(set.center_B == Vec3<double>(0, 0, 0.02));
  CHECK(set.inertia_B(0, 0) == test::relative(3 * (0.4 * 0.01 + 4e-4)).epsilon(1e-14));
}

TEST_CASE("compound: a table stands on its legs, each with a surface of its own") {
  World<double> world;
  BodyDef<double> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<double>{};
  floor.material = {1, 0};
  world.add_body(floor);
  BodyDef<double> def;
  def.shape = Box<double>{{0.5, 0.3, 0.02}};
  def.position = {0, 0, 0.43};
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.25, 0.25}) {
      ShapeDef<double> leg = at(Box<double>{{0.02, 0.02, 0.2}}, {x, y, -0.22});
      leg.material.friction = 0.25;
      def.shapes.push_back(leg);
    }
  }
  const BodyId table = world.add_body(def);
  for (int i = 0; i < 480; ++i) world.step();
  const double mass = world.body(table).mass;
  CHECK(world.pose(table).translation.z() == test::relative(0.42).epsilon(1e-6));
  CHECK(world.contact_impulse(table).force.z() / world.time_step() ==
        test::relative(mass * 9.81).epsilon(1e-4));
  int legs = 0;
  world.for_each_contact([&](const ContactReading<double>& c) { legs += c.is_touching() ? 1 : 0; });
  CHECK(legs == 4);
  // Pushed sideways with more than sqrt(1 * 0.25) of its weight, it slides against just that.
  world.set_velocity(table, {{1, 0, 0}, Vec3<double>::Zero()});
  world.step();
  CHECK(world.contact_impulse(table).force.x() / world.time_step() ==
        test::relative(-0.5 * mass * 9.81).epsilon(1e-3));
}

TEST_CASE("compound: bad shapes are named, and nothing is added") {
  World<double> world;
  const auto field_of = [&](const BodyDef<double>& def) {
    std::string field;
    try {
      world.add_body(def);
    } catch (const InvalidArgument& error) {
      field = error.field();
    }
    CHECK(world.body_count() == 0);
    return field;
  };
  BodyDef<double> def;
  def.shape = Sphere<double>{0.1};
  def.shapes = {at(Sphere<double>{-1}, {0, 0, 0})};
  CHECK(field_of(def) == "Sphere::radius");
  def.shapes = {at(HalfSpace<double>{}, {0, 0, 0})};
  CHECK(field_of(def) == "ShapeDef::shape");
  def.shapes = {at(Sphere<double>{1}, {0, std::nan(""), 0})};
  CHECK(field_of(def) == "ShapeDef::X_BS.translation[1]");
  def.shapes = {at(Sphere<double>{1}, {0, 0, 0})};
  def.shapes[0].X_BS.rotation.w() = 2;
  CHECK(field_of(def) == "ShapeDef::X_BS.rotation");
  def.shapes = {at(Sphere<double>{1}, {0, 0, 0})};
  def.shapes[0].material.friction = -1;
  CHECK(field_of(def) == "Material::friction");
}
