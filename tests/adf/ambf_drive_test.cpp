// AMBF's own scene files are driven: motors send each joint to both of its ends.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/ambf_files.hpp"

#include <bristle/io/adf.hpp>
#include <bristle/io/adf/adf_loop_fit.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;

namespace {

/// [rad, m] A joint is where it should be, or at its limit, if it is this close.
constexpr double is_there = 1e-6;

/// A joint's journey to one end.
struct Drive {
  JointId joint;
  double end = 0.0;
  /// [m], [rad] Largest gap and tilt of any joint after the first steps have closed the file's own.
  double gap = 0.0;
  double tilt = 0.0;
};

/// Ends of a joint's range. Where it has none, a radian or a decimetre to either side.
std::vector<double> ends_of(const JointDef<double>& def) {
  const double far = def.kind == JointKind::revolute ? 1.0 : 0.1;
  return {std::isfinite(def.lower_limit) ? def.lower_limit : -far,
          std::isfinite(def.upper_limit) ? def.upper_limit : far};
}

/// Steps until the joint has arrived, or has had time for the way at a tenth of its speed.
void drive(World<double>& world, const AdfScene<double>& scene, Drive& way) {
  const double speed = 2.0;
  world.set_motor(
      way.joint,
      {.mode = MotorMode::position, .target = way.end, .max_force = 1.0, .max_speed = speed});
  const double distance = std::abs(world.reading(way.joint).position - way.end);
  const auto most = static_cast<int>(10.0 * distance / (speed * world.time_step())) + 100;
  for (int i = 0; i < most; ++i) {
    world.step();
    for (const auto& joint : scene.joints) {
      const JointReading<double> reading = world.reading(joint.value);
      if (i < 10) continue;
      way.gap = std::max(way.gap, reading.gap);
      way.tilt = std::max(way.tilt, reading.tilt);
    }
    const JointReading<double> reading = world.reading(way.joint);
    if (std::abs(reading.position - way.end) < is_there && std::abs(reading.velocity) < 1e-3) break;
  }
}

/// Other joints that stand at an end of their range.
std::vector<JointId> stops(const World<double>& world, const AdfScene<double>& scene,
                           JointId driven) {
  std::vector<JointId> found;
  for (const auto& joint : scene.joints) {
    const JointDef<double>& def = world.joint(joint.value).def;
    const double at = world.reading(joint.value).position;
    const double left = std::min(at - def.lower_limit, def.upper_limit - at);
    if (joint.value != driven && left < is_there) found.push_back(joint.value);
  }
  return found;
}

}  // namespace

TEST_CASE("AMBF's own files: motors bring each joint to both ends, or to where others stop it") {
  for (const std::filesystem::path& file : test::ambf_files()) {
    CAPTURE(file.string());
    // What floats shall only be driven.
    World<double> at_rest({.gravity = {0, 0, 0}, .time_step = 1e-3});
    const AdfScene<double> scene = add_adf(at_rest, file);
    std::size_t driven = 0, reached = 0, stopped = 0;
    double gap = 0.0, tilt = 0.0;
    for (const auto& joint : scene.joints) {
      const JointDef<double>& def = at_rest.joint(joint.value).def;
      if (def.kind != JointKind::revolute && def.kind != JointKind::prismatic) continue;
      ++driven;
      for (const double end : ends_of(def)) {
        CAPTURE(joint.key);
        CAPTURE(end);
        World<double> world = at_rest;
        Drive way{.joint = joint.value, .end = end};
        drive(world, scene, way);
        gap = std::max(gap, way.gap);
        tilt = std::max(tilt, way.tilt);
        const double at = world.reading(joint.value).position;
        if (std::abs(at - end) < is_there) {
          ++reached;
          continue;
        }
        ++stopped;
        // Joints at their limits hold it. It goes on once these are lifted.
        const std::vector<JointId> held_by = stops(world, scene, joint.value);
        CHECK(held_by.size() > 0);
        for (const JointId other : held_by) {
          const double infinity = std::numeric_limits<double>::infinity();
          world.set_limits(other, -infinity, infinity);
        }
        drive(world, scene, way);
        CHECK(std::abs(world.reading(joint.value).position - end) < std::abs(at - end) - 0.01);
      }
    }
    // All holds together while it moves, to a tenth of the digits of a file, and within what these
    // leave open of an axis.
    CHECK(gap < 0.1 * 1e-3);
    CHECK(tilt < detail::adf_axis_rounding);
    MESSAGE(file.filename().string(), " of ", file.parent_path().filename().string(), ": ", driven,
            " joints with an axis, ", reached, " ends reached, ", stopped,
            " stopped by limits of others, largest gap ", gap, " m, tilt ", tilt, " rad");
  }
}
