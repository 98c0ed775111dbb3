/// @file
/// The pinch in MuJoCo: held by patches at any step, and let go below Coulomb's limit.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/hosts/mujoco_host.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <string>

using namespace bristle;

namespace {

struct PinchDef {
  double mass = 0.045;
  double squeeze = 12;
  double offset = 0;
  double dt = 1e-3;
  /// Whether both pads hang on an arm of seven joints.
  bool has_arm = false;
};

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

/// The simulation with its host and patches.
struct Pinch {
  PinchDef def;
  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data{nullptr, mj_deleteData};
  std::unique_ptr<MujocoHost<>> host;
  PatchId left{}, right{};
  int part = 0;

  explicit Pinch(const PinchDef& d) : def(d) {
    const std::string xml = pinch_xml(def);
    auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    REQUIRE(mj_makeEmptyFileVFS(files.get(), "pinch.xml", static_cast<int>(xml.size() + 1)) == 0);
    std::memcpy(files->filedata[0], xml.c_str(), xml.size() + 1);
    char error[500] = "";
    model.reset(mj_loadXML("pinch.xml", files.get(), error, sizeof(error)));
    mj_deleteVFS(files.get());
    REQUIRE_MESSAGE(model != nullptr, error);
    model->opt.timestep = def.dt;
    data.reset(mj_makeData(model.get()));
    part = mj_name2id(model.get(), mjOBJ_BODY, "part");
    mj_forward(model.get(), data.get());
    host = std::make_unique<MujocoHost<>>(*model, *data);
    (void)host->mirror("part");
    GripWants<double> wants;
    wants.friction = 0.7;
    wants.load = def.squeeze;
    wants.mass = def.mass;
    wants.press = 0.45;
    left = host->add_pad("left_pad", 6, 6, wants);
    right = host->add_pad("right_pad", 6, 6, wants);
    data->ctrl[0] = def.squeeze;
    data->ctrl[1] = -def.squeeze;
  }
  void run(double seconds) {
    const long steps = std::lround(seconds / def.dt);
    for (long i = 0; i < steps; ++i) host->step();
  }
  [[nodiscard]] Vec3<double> place() const {
    const mjtNum* x = data->xipos + 3 * part;
    return {x[0], x[1], x[2]};
  }
  /// [m] Where the part is between the pads.
  [[nodiscard]] double height() const {
    const mjtNum* pad = data->xpos + 3 * mj_name2id(model.get(), mjOBJ_BODY, "left");
    return place().z() - pad[2];
  }
  [[nodiscard]] double normal() const {
    return host->world().reading(left).total_normal() + host->world().reading(right).total_normal();
  }
  [[nodiscard]] double weight() const {
    return -host->world().reading(left).wrench.force.z() -
           host->world().reading(right).wrench.force.z();
  }
  [[nodiscard]] double expected_sag() const {
    const double mu_S = host->world().patch(left).def.parameters.static_friction;
    return def.mass * 9.81 / (mu_S * normal());
  }
};

}  // namespace

TEST_CASE("MuJoCo: the pinch holds at any step, and sags by m g / (mu_S sum F_N)") {
  for (const PinchDef& base :
       {PinchDef{.mass = 0.045, .squeeze = 12}, PinchDef{.mass = 2, .squeeze = 60}}) {
    for (const double dt : {5e-4, 1e-3, 2e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60}) {
      CAPTURE(base.mass);
      CAPTURE(dt);
      PinchDef def = base;
      def.dt = dt;
      Pinch pinch(def);
      pinch.run(0.5);
      const double start = pinch.height();
      pinch.model->opt.gravity[2] = -9.81;
      pinch.run(1.5);
      const double there = pinch.height();
      pinch.run(2);
      CHECK(std::abs(pinch.height() - there) < 2e-9);
      CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(1e-3));
      CHECK(pinch.weight() == doctest::Approx(def.mass * 9.81).epsilon(1e-9));
    }
  }
}

TEST_CASE("MuJoCo: a rod whose centre of mass lies beside the pads does not turn on") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    Pinch pinch({.squeeze = 30, .offset = 0.04, .dt = dt});
    pinch.run(0.5);
    pinch.model->opt.gravity[2] = -9.81;
    pinch.run(1.5);
    const Vec3<double> there = pinch.place();
    pinch.run(2);
    CHECK((pinch.place() - there).norm() < 2e-9);
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("MuJoCo: pads on an arm of seven joints hold a part as on slides") {
  for (const double dt : {1e-3, 1.0 / 240, 1.0 / 120}) {
    CAPTURE(dt);
    Pinch pinch({.dt = dt, .has_arm = true});
    pinch.run(1);
    const double start = pinch.height();
    pinch.model->opt.gravity[2] = -9.81;
    pinch.run(3);
    const double there = pinch.height();
    pinch.run(2);
    CHECK(std::abs(pinch.height() - there) < 2e-8);
    CHECK(start - there == doctest::Approx(pinch.expected_sag()).epsilon(0.02));
    CHECK(pinch.weight() == doctest::Approx(pinch.def.mass * 9.81).epsilon(1e-6));
  }
}

TEST_CASE("MuJoCo: a squeeze below Coulomb's limit lets go, and one above it holds") {
  const double limit = 0.045 * 9.81 / (2 * 0.7);
  for (const double factor : {1.01, 0.99}) {
    CAPTURE(factor);
    Pinch pinch({});
    pinch.run(0.5);
    pinch.model->opt.gravity[2] = -9.81;
    pinch.run(0.5);
    for (double squeeze = 12; squeeze > factor * limit; squeeze *= 0.99) {
      pinch.data->ctrl[0] = squeeze;
      pinch.data->ctrl[1] = -squeeze;
      pinch.run(0.01);
    }
    pinch.data->ctrl[0] = factor * limit;
    pinch.data->ctrl[1] = -factor * limit;
    const double start = pinch.height();
    pinch.run(2);
    CHECK((std::abs(pinch.height() - start) < 1e-4) == (factor > 1));
  }
}

TEST_CASE("MuJoCo: names that are not there are named, and nothing has changed") {
  Pinch pinch({});
  const std::uint64_t before = pinch.host->world().state_hash();
  CHECK_THROWS_WITH_AS(pinch.host->mirror("thumb"), doctest::Contains("thumb"), InvalidArgument);
  CHECK_THROWS_WITH_AS(pinch.host->add_pad("thumb_pad", 2, 2, {}), doctest::Contains("thumb_pad"),
                       InvalidArgument);
  CHECK(pinch.host->world().state_hash() == before);
}

TEST_CASE("MuJoCo: what a caller applies stays, and what sensors apply does not") {
  Pinch pinch({});
  pinch.data->xfrc_applied[6 * pinch.part + 1] = 0.25;
  pinch.run(0.2);
  for (int i = 0; i < 6 * pinch.model->nbody; ++i) {
    CHECK(pinch.data->xfrc_applied[i] == (i == 6 * pinch.part + 1 ? 0.25 : 0.0));
  }
  CHECK(pinch.host->world().reading(pinch.left).wrench.force.y() +
            pinch.host->world().reading(pinch.right).wrench.force.y() ==
        doctest::Approx(0.25).epsilon(1e-3));
}
