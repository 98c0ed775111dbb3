/// @file
/// The pinch in MuJoCo.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/mujoco_pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("MuJoCo: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  check_holds<MujocoPinch>({.mass = 0.045, .squeeze = 12}, {});
  check_holds<MujocoPinch>({.mass = 2, .squeeze = 60}, {});
}

TEST_CASE("MuJoCo: a part whose centre of mass lies beside the pads is held against turning") {
  check_holds<MujocoPinch>({.squeeze = 30, .offset = 0.04}, {});
}

TEST_CASE("MuJoCo: the squeeze decides whether a part is held or let go") {
  check_lets_go<MujocoPinch>();
}

TEST_CASE("MuJoCo: a shaken part swings as a spring and damper does, and comes back") {
  check_shaken<MujocoPinch>();
}

TEST_CASE("MuJoCo: pads that come from out of reach catch a part in a long step") {
  check_caught<MujocoPinch>({});
}

TEST_CASE("MuJoCo: pads on an arm of seven joints hold a part as on slides") {
  check_on_arm<MujocoPinch>();
}

TEST_CASE("MuJoCo: the part gains the momentum that readings tell") {
  check_momentum<MujocoPinch>({});
}

// MuJoCo's contacts are soft, and creep where sensors hold. Those of the other engines are hard,
// without a memory, and undo what bristles do: docs/hosts.md has the figures.
TEST_CASE(
    "MuJoCo: sensors keep a part from creeping out of contacts that bear a part of the squeeze") {
  for (const double dt : {1e-3, 1.0 / 240}) {
    CAPTURE(dt);
    MujocoPinch pinch({.dt = dt, .has_contacts = true});
    pinch.run(1);
    pinch.gravity = {0, 0, -9.81};
    pinch.run(5);
    const double there = pinch.place().z();
    double most = 0;
    for (int i = 0; i < 200; ++i) {
      pinch.run(0.1);
      most = std::max(most, std::abs(pinch.place().z() - there));
    }
    // By contacts alone it creeps by 1.5 mm/s. Between the pads it is shaken by them.
    CHECK(most < 5e-6);
    CHECK(pinch.normal() < 2 * pinch.def.squeeze);
    CHECK(pinch.normal() > pinch.def.squeeze);
  }
}

TEST_CASE(
    "MuJoCo: what pads hold that mocap leads follows them as the velocity that they are given") {
  const double speed = 0.1;
  for (const double dt : {1e-3, 1.0 / 240}) {
    for (const bool is_told : {true, false}) {
      CAPTURE(dt);
      CAPTURE(is_told);
      PinchDef def;
      std::string pads;
      for (const double side : {-1.0, 1.0}) {
        pads += "<body name=\"" + std::string(side < 0 ? "left" : "right") +
                "\" mocap=\"true\" pos=\"" + mujoco_text(side * 0.0114) + " 0 0\"/>";
      }
      const MujocoModel model = mujoco_model_of(
          "<mujoco><option timestep=\"" + mujoco_text(dt) + "\"/><worldbody>" + pads +
          "<body name=\"part\"><freejoint/><geom type=\"box\" size=\"0.005 0.01 0.01\" mass=\"" +
          mujoco_text(def.mass) + "\"/></body></worldbody></mujoco>");
      model->opt.timestep = dt;
      const MujocoData data(mj_makeData(model.get()), mj_deleteData);
      mj_forward(model.get(), data.get());
      MujocoHost<> host(*model, *data);
      (void)host.mirror("part");
      const std::array<PatchId, 2> patches{host.add_patch("left", pinch_pad(1, def.spec())),
                                           host.add_patch("right", pinch_pad(-1, def.spec()))};
      if (is_told) {
        for (const char* side : {"left", "right"})
          host.set_velocity(side, {{0, 0, speed}, {0, 0, 0}});
      }
      // Part and pads start together.
      data->qvel[2] = speed;
      const int part = mj_name2id(model.get(), mjOBJ_BODY, "part");
      for (int i = 0; i < 2 / dt; ++i) {
        host.step();
        for (const int k : {2, 5}) data->mocap_pos[k] += speed * dt;
      }
      mj_kinematics(model.get(), data.get());
      const PatchReading<double> left = host.world().reading(patches[0]);
      const PatchReading<double> right = host.world().reading(patches[1]);
      const SensorParameters<double> p = host.world().patch(patches[0]).def.parameters;
      const double k = p.static_friction * (left.total_normal() + right.total_normal());
      const double c = p.sliding_friction * static_cast<double>(left.touching() + right.touching());
      const double sag = data->mocap_pos[2] - data->xipos[3 * part + 2];
      // A pad that is taken to stand still damps the part's whole motion, and its bristles lag by a
      // part of a step more.
      const double expected = def.mass * 9.81 / k + (is_told ? 0 : c / k * speed);
      CHECK(std::abs(sag - expected) < (is_told ? 1e-9 : speed * dt));
      CHECK(c * speed > 0.1 * def.mass * 9.81);
    }
  }
}

// MuJoCo puts the frame of a mesh at its centre of mass, along its principal axes.
TEST_CASE("MuJoCo: a mesh geom becomes a skin that looks out of its faces") {
  const MujocoModel model = mujoco_model_of(
      "<mujoco><asset><mesh name=\"wedge\" vertex=\"0 0 0  0.1 0 0  0 0.06 0  0 0 0.04\"/></asset>"
      "<worldbody><body name=\"finger\" pos=\"0.1 0.2 0.3\" euler=\"10 20 30\"><freejoint/>"
      "<geom name=\"tip\" type=\"mesh\" mesh=\"wedge\" pos=\"0.01 0 0.02\"/>"
      "<geom name=\"ball\" size=\"0.001\"/></body></worldbody></mujoco>");
  const MujocoData data(mj_makeData(model.get()), mj_deleteData);
  mj_forward(model.get(), data.get());
  MujocoHost<> host(*model, *data);
  const PatchId patch = host.add_skin("tip", {.depth = 0.001, .range = 0.004}, {});
  const auto& skin = host.world().patch(patch);
  REQUIRE(skin.size() == 4);
  // Rays start 1 mm below the hull that MuJoCo collides, and leave it head-on.
  const BodyId finger = host.mirror("finger");
  const Transform<double> X_WB = host.world().pose(finger);
  const Vec3<double> center = host.world().body(finger).center_pose.translation;
  for (std::size_t i = 0; i < skin.size(); ++i) {
    const Vec3<double> start = center + X_WB.rotation * skin.geometry->start[i];
    const Vec3<double> along = X_WB.rotation * skin.geometry->direction[i];
    const WorldHit<double> hit = host.world().cast_ray({start + 0.01 * along, -along, 0.02});
    CHECK(hit.distance == test::relative(0.009).epsilon(1e-5));
    CHECK(hit.normal.dot(along) == test::relative(1.0).epsilon(1e-6));
  }
  CHECK_THROWS_WITH_AS(host.add_skin("ball", {}, {}), doctest::Contains("must be of type mesh"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(host.add_skin("nail", {}, {}), doctest::Contains("geom = nail"),
                       InvalidArgument);
}

TEST_CASE("MuJoCo: all that hangs on a body that mocap leads moves with it") {
  const MujocoModel model = mujoco_model_of(
      "<mujoco><worldbody><body name=\"hand\" mocap=\"true\"><geom type=\"box\" "
      "size=\"0.1 0.1 0.1\"/><body name=\"pad\" pos=\"0 0.2 0\"><geom type=\"sphere\" "
      "size=\"0.01\"/></body></body></worldbody></mujoco>");
  const MujocoData data(mj_makeData(model.get()), mj_deleteData);
  mj_forward(model.get(), data.get());
  MujocoHost<> host(*model, *data);
  const BodyId pad = host.mirror("pad");
  host.set_velocity("hand", {{1, 0, 0}, {0, 0, 2}});
  const HostBody<double> body = *host.body(pad);
  CHECK((body.twist.linear - Vec3<double>(1 - 2 * 0.2, 0, 0)).norm() < 1e-12);
  CHECK((body.twist.angular - Vec3<double>(0, 0, 2)).norm() < 1e-12);
  data->mocap_pos[2] = 0.5;
  host.step();
  CHECK(host.world().pose(pad).translation.z() == test::relative(0.5));
}

TEST_CASE("MuJoCo: velocities are for bodies that mocap leads") {
  MujocoPinch pinch{{}};
  CHECK_THROWS_WITH_AS(pinch.host->set_velocity("part", {}), doctest::Contains("mocap"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(pinch.host->set_velocity("thumb", {}), doctest::Contains("thumb"),
                       InvalidArgument);
}

TEST_CASE("MuJoCo: a body has the shapes that a caller gives it") {
  MujocoPinch pinch{{}};
  pinch.host->forget(pinch.part_number);
  ShapeDef<double> ball;
  ball.shape = Sphere<double>{0.005};
  const BodyId id = pinch.host->mirror("part", {ball});
  CHECK(pinch.host->mirror("part") == id);
  CHECK(pinch.host->world().cast_ray({{0.003, 0, 1}, {0, 0, -1}, 2}).distance ==
        test::relative(1 - 0.004));
}

TEST_CASE("MuJoCo: a body that a caller adds to the mirror himself is missing, and harms nobody") {
  check_stranger<MujocoPinch>();
}

TEST_CASE("MuJoCo: names that are not there are named, and nothing has changed") {
  MujocoPinch pinch{{}};
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror("thumb"), doctest::Contains("thumb"), InvalidArgument);
  CHECK_THROWS_WITH_AS(pinch.host->add_pad("thumb_pad", 2, 2, {}), doctest::Contains("thumb_pad"),
                       InvalidArgument);
  for (const int number : {-1, pinch.model->nbody, 100000000}) {
    CHECK_THROWS_WITH_AS(pinch.host->mirror(number), doctest::Contains("body = "), InvalidArgument);
  }
  CHECK(pinch.host->world().state_hash() == before);
}

TEST_CASE("MuJoCo: a pad of a site has the scaling that its constants are made for") {
  MujocoPinch pinch{{}};
  const PatchId pad = pinch.host->add_pad("left_pad", 2, 2, {.scaling = FrictionScaling::none});
  CHECK(pinch.host->world().patch(pad).def.options.scaling == FrictionScaling::none);
}

TEST_CASE("MuJoCo: what a caller applies stays, and what sensors apply does not") {
  MujocoPinch pinch{{}};
  pinch.data->xfrc_applied[6 * pinch.part_number + 1] = 0.25;
  pinch.run(0.2);
  for (int i = 0; i < 6 * pinch.model->nbody; ++i) {
    CHECK(pinch.data->xfrc_applied[i] == (i == 6 * pinch.part_number + 1 ? 0.25 : 0.0));
  }
  CHECK(pinch.host->world().reading(pinch.patches[0]).wrench.force.y() +
            pinch.host->world().reading(pinch.patches[1]).wrench.force.y() ==
        test::relative(0.25).epsilon(1e-3));
}

TEST_CASE("MuJoCo: a body is let go, and mirrored again") {
  MujocoPinch pinch{{}};
  pinch.run(0.1);
  CHECK(pinch.reading(0).touching() == 36);
  pinch.host->forget(pinch.part_number);
  pinch.step();
  CHECK(pinch.reading(0).touching() == 0);
  (void)pinch.host->mirror("part");
  pinch.run(0.1);
  CHECK(pinch.reading(0).touching() == 36);
}

// MuJoCo's own rays tell where the surface is. Heights are at least 0 there.
TEST_CASE("MuJoCo: a height field is seen where MuJoCo's rays meet it") {
  const std::string xml =
      "<mujoco><asset><hfield name=\"field\" nrow=\"9\" ncol=\"13\" size=\"0.6 0.4 0.2 0.1\"/>"
      "</asset><worldbody><body name=\"ground\" pos=\"0.1 -0.2 0.3\" euler=\"0 0 30\">"
      "<geom type=\"hfield\" hfield=\"field\"/></body></worldbody></mujoco>";
  const MujocoModel model = mujoco_model_of(xml);
  const auto field = [](double x, double y) {
    return 0.6 + 0.3 * x - 0.2 * y + 0.1 * std::sin(7 * x) + 0.1 * std::cos(9 * y);
  };
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 13; ++i) {
      model->hfield_data[13 * j + i] = static_cast<float>(field(0.1 * i - 0.6, 0.1 * j - 0.4));
    }
  }
  const MujocoData data(mj_makeData(model.get()), mj_deleteData);
  mj_forward(model.get(), data.get());
  MujocoHost<> host(*model, *data);
  (void)host.mirror("ground");
  test::Random random(3);
  for (int k = 0; k < 200; ++k) {
    const double turn = std::numbers::pi / 6;
    const double x = random.uniform(-0.59, 0.59);
    const double y = random.uniform(-0.39, 0.39);
    const Vec3<double> from(0.1 + std::cos(turn) * x - std::sin(turn) * y,
                            -0.2 + std::sin(turn) * x + std::cos(turn) * y, 5);
    const mjtNum down[3] = {0, 0, -1};
    int geom = -1;
    const double expected =
        mj_ray(model.get(), data.get(), from.data(), down, nullptr, 1, -1, &geom);
    REQUIRE(expected > 0);
    const auto hit = host.world().cast_ray({.origin = from, .direction = {0, 0, -1}});
    REQUIRE(hit.is_hit());
    CHECK(std::abs(hit.distance - expected) <= 1e-9);
  }
}
