// A scene file in AMBF's description format, loaded, run and recorded.
//
//   ./examples/run scene robot.yaml --replay robot.html
//
// Joints with a controller hold where they stand. Prints where the bodies end up, and what of the
// file was not taken as it stands.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/replay.hpp"
#include "support/table.hpp"

#include <bristle/bristle.hpp>
#include <bristle/io/adf.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

namespace {

using bristle::AdfScene;
using bristle::World;

constexpr const char* usage =
    R"(Usage: scene [FILE.yaml] [OPTION...]

  FILE.yaml          the scene (a parallel gripper that ships with the examples)
  --seconds SECONDS  for how long it runs (2)
  --dt SECONDS       length of a step (0.001)
  --replay FILE      writes the motion as binary glTF (.glb); by examples/run a page, too (.html)
  --help             this text

Exit status: 0, 1 for a scene that cannot be loaded or recorded, 2 for a wrong option.
)";

struct Settings {
  std::string file = BRISTLE_EXAMPLE_DIR "/../scenes/parallel_gripper.yaml";
  double seconds = 2;
  double time_step = 1e-3;
  std::string replay;
};

[[noreturn]] void fail(const std::string& message) {
  std::fprintf(stderr, "scene: %s\nTry --help.\n", message.c_str());
  std::exit(2);
}

double positive(const std::string& option, const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value > 0) || !std::isfinite(value)) {
    fail(option + " " + text + ": must be a number of seconds > 0");
  }
  return value;
}

Settings parse(int argc, char** argv) {
  Settings settings;
  bool has_file = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--help" || option == "-h") {
      std::fputs(usage, stdout);
      std::exit(0);
    }
    if (!option.starts_with("--")) {
      if (has_file) fail("'" + option + "': must be the only file");
      settings.file = option;
      has_file = true;
      continue;
    }
    if (option != "--seconds" && option != "--dt" && option != "--replay") {
      fail("unknown option '" + option + "'");
    }
    if (i + 1 == argc) fail(option + " needs a value");
    const std::string value = argv[++i];
    if (option == "--seconds") settings.seconds = positive(option, value);
    if (option == "--dt") settings.time_step = positive(option, value);
    if (option == "--replay") settings.replay = value;
  }
  return settings;
}

/// Names in the recording are those of the file.
void name_things(figure::Replay& replay, const World<double>& world,
                 const AdfScene<double>& scene) {
  for (const auto& body : scene.bodies) {
    replay.recorder().add_body(world, body.value, body.name);
  }
  for (const auto& patch : scene.patches) {
    replay.recorder().add_patch(world, patch.value, patch.name);
  }
  for (const auto& joint : scene.joints) {
    replay.recorder().add_joint(world, joint.value, joint.name);
  }
}

void run(const Settings& settings) {
  figure::Replay replay(settings.replay);
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = settings.time_step});
  const AdfScene<double> scene = bristle::add_adf(world, settings.file, {.hold_joints = true});
  if (replay.is_wanted()) name_things(replay, world, scene);
  const long steps = std::lround(settings.seconds / settings.time_step);
  for (long i = 0; i < steps; ++i) {
    world.step();
    replay.observe(world);
  }
  std::printf("%zu bodies, %zu joints, %zu patches after %g s:\n", scene.bodies.size(),
              scene.joints.size(), scene.patches.size(), settings.seconds);
  figure::Table table({"body", "x [mm]", "y [mm]", "z [mm]"});
  for (const auto& body : scene.bodies) {
    std::vector<figure::Cell> row{body.name};
    const bristle::Vec3<double> place = world.pose(body.value).translation;
    for (const double x : place) row.push_back(figure::number("%.1f", 1e3 * x, 0.05));
    table.add(row);
  }
  table.print();
  std::printf("not taken as it stands:\n%s", scene.report.text().c_str());
  replay.write();
}

}  // namespace

int main(int argc, char** argv) {
  const Settings settings = parse(argc, argv);
  try {
    run(settings);
  } catch (const std::exception& error) {
    // A file that cannot be loaded or written, or a name in it that is no UTF-8.
    std::fprintf(stderr, "scene: %s\n", error.what());
    return 1;
  }
}
