/// @file
/// The pinch in MuJoCo.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/hosts/mujoco_host.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numbers>
#include <string>

using namespace bristle;
using namespace bristle::scenes;

namespace {

std::string text(double x) { return std::to_string(x); }

/// Two pads on slides and a part between them that collide with nothing in MuJoCo.
std::string pinch_xml(const PinchDef& def) {
  // On a tilted arm nothing but springs keeps pads and part between the ends of the slides.
  const char* spring = def.has_arm ? " stiffness=\"1000\" damping=\"20\"" : "";
  const auto pad = [&](const char* name, double side) {
    return "<body name=\"" + std::string(name) + "\" pos=\"" + text(side * 0.0101) +
           " 0 0\"><joint name=\"" + name + "\" type=\"slide\" axis=\"1 0 0\"" + spring +
           "/><geom type=\"box\" size=\"0.005 0.01 0.01\" "
           "mass=\"0.1\" contype=\"0\" conaffinity=\"0\"/><site name=\"" +
           name + "_pad\" type=\"box\" size=\"0.009 0.009 0.004\" pos=\"" + text(-side * 0.006) +
           " 0 0\" zaxis=\"" + text(-side) + " 0 0\"/></body>";
  };
  std::string pads = pad("left", -1) + pad("right", 1);
  if (def.has_arm) {
    // From the shoulder up, over and down to the pads.
    const char* axes[7] = {"0 0 1", "0 1 0", "1 0 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1"};
    const char* places[7] = {"-0.5 0 -0.3", "0 0 0.1", "0 0 0.2",    "0 0 0.1",
                             "0.2 0 0",     "0.2 0 0", "0.1 0 -0.05"};
    std::string open, close;
    for (int i = 0; i < 7; ++i) {
      open += "<body pos=\"" + std::string(places[i]) + "\"><joint name=\"arm" + std::to_string(i) +
              "\" axis=\"" + axes[i] +
              "\" stiffness=\"2000\" damping=\"20\" armature=\"0.01\"/><geom type=\"sphere\" "
              "size=\"0.04\" mass=\"1\" contype=\"0\" conaffinity=\"0\"/>";
      close += "</body>";
    }
    // The wrist's frame in the world is the sum of the places.
    pads = open + "<body pos=\"0 0 -0.05\">" + pads + "</body>" + close;
  }
  const double own = def.offset > 0 ? 0.5 * def.mass : def.mass;
  const std::string beside = def.offset > 0
                                 ? "<geom type=\"sphere\" size=\"0.005\" pos=\"0 " +
                                       text(2 * def.offset) + " 0\" mass=\"" +
                                       text(def.mass - own) + "\" contype=\"0\" conaffinity=\"0\"/>"
                                 : "";
  return "<mujoco><option timestep=\"" + std::to_string(def.dt) +
         "\" gravity=\"0 0 0\"/><worldbody>" + pads +
         "<body name=\"part\"><freejoint/><geom type=\"box\" size=\"0.005 0.01 0.01\" mass=\"" +
         text(own) + "\" contype=\"0\" conaffinity=\"0\"/>" + beside +
         "</body></worldbody><actuator><motor joint=\"left\"/><motor joint=\"right\"/></actuator>"
         "</mujoco>";
}

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Model model_of(const std::string& xml) {
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  REQUIRE(mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(xml.size() + 1)) == 0);
  std::memcpy(files->filedata[0], xml.c_str(), xml.size() + 1);
  char error[500] = "";
  Model model(mj_loadXML("model.xml", files.get(), error, sizeof(error)), mj_deleteModel);
  mj_deleteVFS(files.get());
  REQUIRE_MESSAGE(model != nullptr, error);
  return model;
}

class MujocoPinch : public Pinch {
 public:
  explicit MujocoPinch(const PinchDef& d) : Pinch(d), model(model_of(pinch_xml(def))) {
    model->opt.timestep = def.dt;
    data.reset(mj_makeData(model.get()));
    part_number = mj_name2id(model.get(), mjOBJ_BODY, "part");
    mj_forward(model.get(), data.get());
    host = std::make_unique<MujocoHost<>>(*model, *data);
    (void)host->mirror("part");
    patches = {host->add_pad("left_pad", 6, 6, def.spec()),
               host->add_pad("right_pad", 6, 6, def.spec())};
  }

  [[nodiscard]] World<double>& world() override { return host->world(); }
  [[nodiscard]] std::size_t missing() override { return host->sensors().report().missing_bodies; }
  [[nodiscard]] Vec3<double> part() const override {
    const mjtNum* x = data->xipos + 3 * part_number;
    return {x[0], x[1], x[2]};
  }
  [[nodiscard]] Vec3<double> pad(std::size_t k) const override {
    const mjtNum* x = data->xpos + 3 * mj_name2id(model.get(), mjOBJ_BODY, sides[k]);
    return {x[0], x[1], x[2]};
  }
  void open(double gap, double speed) override {
    for (std::size_t k = 0; k < 2; ++k) {
      const int joint = mj_name2id(model.get(), mjOBJ_JOINT, sides[k]);
      const double side = k == 0 ? 1 : -1;
      data->qpos[model->jnt_qposadr[joint]] -= side * gap;
      data->qvel[model->jnt_dofadr[joint]] = side * speed;
    }
    mj_kinematics(model.get(), data.get());
  }
  void step() override {
    data->ctrl[0] = def.squeeze;
    data->ctrl[1] = -def.squeeze;
    for (int i = 0; i < 3; ++i) model->opt.gravity[i] = gravity[i];
    host->step();
    // MuJoCo leaves places as they were at the step's start.
    mj_kinematics(model.get(), data.get());
  }

  Model model;
  Data data{nullptr, mj_deleteData};
  std::unique_ptr<MujocoHost<>> host;
  int part_number = 0;

 private:
  static constexpr const char* sides[2] = {"left", "right"};
};

}  // namespace

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
  const Model model = model_of(xml);
  const auto field = [](double x, double y) {
    return 0.6 + 0.3 * x - 0.2 * y + 0.1 * std::sin(7 * x) + 0.1 * std::cos(9 * y);
  };
  for (int j = 0; j < 9; ++j) {
    for (int i = 0; i < 13; ++i) {
      model->hfield_data[13 * j + i] = static_cast<float>(field(0.1 * i - 0.6, 0.1 * j - 0.4));
    }
  }
  const Data data(mj_makeData(model.get()), mj_deleteData);
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
