// The scene files of AMBF itself, where they are at hand: in ../shared/ambf beside this tree, or
// where BRISTLE_AMBF_DIR says.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

using namespace bristle;

namespace {

std::vector<std::filesystem::path> ambf_files() {
  const char* named = std::getenv("BRISTLE_AMBF_DIR");
  const std::filesystem::path folder = named != nullptr ? named : BRISTLE_AMBF_DIR;
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) MESSAGE("skipped: no scene files in ", folder.string());
  return files;
}

}  // namespace

TEST_CASE("AMBF's own files: load and run for ten seconds without a blow-up") {
  for (const std::filesystem::path& file : ambf_files()) {
    CAPTURE(file.string());
    const double g = 9.81;
    World<double> world({.gravity = {0, 0, -g}, .time_step = 1e-3});
    const AdfScene<double> scene = add_adf<double>(world, file);
    CHECK(scene.bodies.size() > 0);
    for (const AdfNote& note : scene.report.notes()) {
      CAPTURE(note.key);
      CHECK(note.kind != AdfNoteKind::left_out);
    }
    // Nothing but gravity acts, and what stands in the way or is joined takes energy: no centre of
    // mass is faster than a free fall of that time, but for what swings back and forth on others
    // and what pushes apart bodies that overlap or joints outside their limits in the file.
    const double slack = 5.0;
    double worst = 0.0;
    bool is_finite = true;
    for (int i = 1; i <= 10'000; ++i) {
      world.step();
      for (const auto& body : scene.bodies) {
        const double speed = world.body(body.value).twist.linear.norm();
        is_finite = is_finite && std::isfinite(speed);
        worst = std::max(worst, speed - g * 1e-3 * i);
      }
    }
    CHECK(is_finite);
    CHECK(worst < slack);
    MESSAGE(file.filename().string(), " of ", file.parent_path().filename().string(), ": ",
            scene.bodies.size(), " bodies, ", scene.joints.size(),
            " joints, fastest beyond free fall by ", worst, " m/s");
  }
}
