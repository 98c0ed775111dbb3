// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <string>

using namespace bristle;

namespace {

/// A grid on the underside of a box of 60 mm, as in the README, its sides exchanged or not.
template <typename S>
SensorLayout<S> underside(bool is_exchanged, S bottom = S(-0.03)) {
  SensorGridDef<S> def{.center = Vec3<S>(0, 0, bottom),
                       .side_u = Vec3<S>(0, S(0.06), 0),
                       .side_v = Vec3<S>(S(0.06), 0, 0),
                       .count_u = 5,
                       .count_v = 5};
  if (is_exchanged) std::swap(def.side_u, def.side_v);
  return sensor_grid<S>(def);
}

template <typename S>
BodyDef<S> box_body() {
  return {.mass = S(0.5), .shape = Box<S>{.half_extents = Vec3<S>::Constant(S(0.03))}};
}

/// The message of a refusal, which must leave the world as it was; empty where it was accepted.
template <typename S>
std::string refusal(World<S>& world, BodyId body, const PatchDef<S>& def) {
  const auto before = world.state_hash();
  try {
    world.add_patch(body, def);
  } catch (const InvalidArgument& error) {
    CHECK(world.state_hash() == before);
    return error.what();
  }
  return {};
}

template <typename S>
std::string refusal(World<S>& world, BodyId body, SensorLayout<S> sensors) {
  PatchDef<S> def;
  def.sensors = std::move(sensors);
  def.parameters.normal_stiffness = S(10);
  return refusal(world, body, def);
}

template <typename S>
SensorLayout<S> one(const Vec3<S>& start, const Vec3<S>& end) {
  SensorLayout<S> layout;
  layout.add(start, end);
  return layout;
}

}  // namespace

TEST_CASE_TEMPLATE("sensors into the body: exchanged sides are refused by name", S, double, float) {
  World<S> world;
  const BodyId box = world.add_body(box_body<S>());
  CHECK(refusal(world, box, underside<S>(false)) == "");
  const std::string message = refusal(world, box, underside<S>(true));
  CHECK(message.find("PatchDef::sensors[0]") != std::string::npos);
  CHECK(message.find("must lie outside of the shapes of its own body") != std::string::npos);
  // The first that does is named, and its end.
  SensorLayout<S> mixed = underside<S>(false);
  mixed.add(Vec3<S>(0, 0, S(0.0625)), Vec3<S>(0, 0, S(0.015625)));
  CHECK(refusal(world, box, mixed).find("PatchDef::sensors[25]") != std::string::npos);
  CHECK(refusal(world, box, mixed).find("(0, 0, 0.015625)") != std::string::npos);
}

TEST_CASE_TEMPLATE("sensors into the body: they are accepted by who means it", S, double, float) {
  World<S> world;
  const BodyId box = world.add_body(box_body<S>());
  PatchDef<S> def;
  def.sensors = underside<S>(true);
  def.parameters.normal_stiffness = S(10);
  def.may_point_inwards = true;
  CHECK(refusal(world, box, def) == "");
}

TEST_CASE_TEMPLATE("sensors into the body: rays may start within, on or off the surface", S, double,
                   float) {
  World<S> world;
  const BodyId box = world.add_body(box_body<S>());
  const Vec3<S> x = Vec3<S>::UnitX();
  CHECK(refusal(world, box, one<S>(Vec3<S>::Zero(), S(0.04) * x)) == "");
  CHECK(refusal(world, box, one<S>(S(0.03) * x, S(0.04) * x)) == "");
  CHECK(refusal(world, box, one<S>(S(0.05) * x, S(1) * x)) == "");
  // A body without shapes has no inside.
  const BodyId bare = world.add_body({.mass = S(1), .inertia = Mat3<S>::Identity()});
  CHECK(refusal(world, bare, underside<S>(true)) == "");
}

TEST_CASE_TEMPLATE("sensors into the body: rays that look through it are refused", S, double,
                   float) {
  World<S> world;
  const BodyId box = world.add_body(box_body<S>());
  const Vec3<S> x = Vec3<S>::UnitX();
  const std::string message = refusal(world, box, one<S>(S(-0.0625) * x, S(0.0625) * x));
  CHECK(message.find("PatchDef::sensors[0]: entry of the ray") != std::string::npos);
  CHECK(message.find("(-0.03") != std::string::npos);
  // A plate of 2 mm, thinner than the 5 mm that the rays start below its surface, whether they look
  // out of it or, with sides exchanged, into it.
  const BodyId plate = world.add_body(
      {.mass = S(0.5), .shape = Box<S>{.half_extents = Vec3<S>(S(0.03), S(0.03), S(0.001))}});
  for (const bool is_exchanged : {false, true}) {
    const std::string of_plate = refusal(world, plate, underside<S>(is_exchanged, S(-0.001)));
    CHECK(of_plate.find("and 24 more sensors") != std::string::npos);
    PatchDef<S> meant;
    meant.sensors = underside<S>(is_exchanged, S(-0.001));
    meant.may_point_inwards = true;
    CHECK(refusal(world, plate, meant) == "");
  }
  // From the far face on, to round-off, a ray starts inside; and a fan beside the plate misses it.
  CHECK(refusal(world, plate, one<S>({0, 0, S(0.001)}, {0, 0, S(-0.006)})) == "");
  CHECK(refusal(world, plate, one<S>({S(0.04), 0, S(0.01)}, {S(0.04), 0, S(-0.01)})) == "");
}

TEST_CASE("sensors into the body: any of several shapes counts, where they are") {
  World<double> world;
  BodyDef<double> def;
  def.mass = 1.0;
  def.shapes.push_back(
      {.shape = Sphere<double>{.radius = 0.1}, .X_BS = {.translation = {0.3, 0, 0}}});
  def.shapes.push_back(
      {.shape = Sphere<double>{.radius = 0.1}, .X_BS = {.translation = {-0.3, 0, 0}}});
  def.center_of_mass = Vec3<double>(0, 0, 0.05);
  def.inertia = Mat3<double>::Identity();
  const BodyId body = world.add_body(def);
  CHECK(refusal(world, body, one<double>({0.3, 0, 0}, {0.15, 0, 0})) == "");
  CHECK(refusal(world, body, one<double>({0.3, 0, 0}, {-0.3, 0, 0})) != "");
  CHECK(refusal(world, body, one<double>({0, 0, 0}, {-0.25, 0, 0})) != "");
  CHECK(refusal(world, body, one<double>({0.3, 0, 0.05}, {0.3, 0, 0.12})) == "");
}

TEST_CASE_TEMPLATE("sensors into the body: skins of meshes point out, and not in", S, double,
                   float) {
  const TriangleMesh<S> mesh = sphere_mesh<S>(S(0.05), 2);
  World<S> world;
  const BodyId body = world.add_body({.mass = S(1), .shape = mesh});
  const SensorLayout<S> skin =
      sensors_from_mesh<S>(mesh, {.faces = true, .vertices = true, .edges = true});
  CHECK(refusal(world, body, skin) == "");
  SensorLayout<S> inwards = skin;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    inwards.start.set(i, skin.start[i] + skin.length[i] * skin.direction[i]);
    inwards.direction.set(i, -skin.direction[i]);
  }
  CHECK(refusal(world, body, inwards).find("PatchDef::sensors[0]") != std::string::npos);
}
