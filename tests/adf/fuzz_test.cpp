// Damaged scenes, and scenes of damaged meshes: a model or an error, never anything else.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/example_scenes.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/adf.hpp>
#include <bristle/io/obj.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <support/damage.hpp>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <support/temp_folder.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::damaged;
using bristle::test::example_scenes;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

/// Words that numbers, structure and names stumble over.
constexpr const char* words[] = {"1e308",
                                 "-1e-320",
                                 "-1",
                                 ".nan",
                                 ".inf",
                                 "0",
                                 "[",
                                 "{",
                                 "]",
                                 "}",
                                 ": ",
                                 "- ",
                                 "? ",
                                 "\n",
                                 "\n  ",
                                 "\t",
                                 "<<: *skin\n",
                                 "<<: *finger\n",
                                 "&skin ",
                                 "*skin",
                                 "*finger",
                                 "*left",
                                 "!!binary ",
                                 "|\n",
                                 "'",
                                 "\"",
                                 "#",
                                 "%",
                                 "---\n",
                                 "BODY Part",
                                 "/dev/zero",
                                 "../",
                                 "resistive surface: {mesh: pad.stl}\n",
                                 "999999999999",
                                 "resolution: 9999",
                                 "mass: 0",
                                 "CAPSULE",
                                 "six dof spring"};

AdfLimits small_limits() {
  AdfLimits limits;
  limits.max_bytes = 1 << 20;
  limits.max_items = 1000;
  limits.max_rays = 10'000;
  return limits;
}

/// Returns whether a text becomes part of a world. If so, the world takes a few steps, and no state
/// is spoilt.
bool loads(const std::string& text) {
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});
  AdfBuildDef<double> def;
  def.limits = small_limits();
  try {
    AdfScene<double> scene =
        add_adf(world, read_adf(text, example_scenes / "damaged.yaml", def.limits), def);
    for (int i = 0; i < 3; ++i) world.step();
    for (const auto& body : scene.bodies) {
      CHECK(std::isfinite(world.body(body.value).twist.linear.norm()));
    }
    for (auto& entry : scene.proximity)
      world.sense(entry.value.carrier, scene.proximity.at(entry.qualified).rays);
    return true;
  } catch (const IoError&) {
    CHECK(world.body_count() == 0);
    return false;
  }
}

}  // namespace

TEST_CASE("add_adf: damaged scenes end in IoError or a world that steps, never otherwise") {
  const std::uint64_t seed = 20190906;
  CAPTURE(seed);
  Random random(seed);
  for (const char* name : {"parallel_gripper.yaml", "chain.yaml", "inclined_box.yaml"}) {
    CAPTURE(name);
    const std::string original = read_file(example_scenes / name);
    int loaded = 0;
    const int count = rounds(400);
    for (int round = 0; round < count; ++round) {
      CAPTURE(round);
      loaded += loads(damaged(original, random, words)) ? 1 : 0;
    }
    // Both ends are reached, or the damage proves nothing.
    CHECK(loaded > count / 50);
    CHECK(loaded < count - count / 10);
  }
}

TEST_CASE("read_adf: bytes of any kind end in AdfError or a model") {
  const std::uint64_t seed = 7;
  CAPTURE(seed);
  Random random(seed);
  int errors = 0;
  const int count = rounds(3000);
  for (int round = 0; round < count; ++round) {
    CAPTURE(round);
    std::string text;
    const std::size_t length = random.index(300);
    while (text.size() < length) {
      // Half words of the language, half bytes.
      if (random.index(2) == 0) {
        text += words[random.index(std::size(words))];
      } else {
        text += static_cast<char>(random.index(256));
      }
    }
    try {
      (void)read_adf(text, "bytes.yaml");
    } catch (const AdfError& error) {
      ++errors;
      CHECK(error.file() == "bytes.yaml");
    }
  }
  CHECK(errors > count / 2);
}

TEST_CASE("add_adf: damaged meshes end in IoError or a world that steps, never otherwise") {
  const std::uint64_t seed = 11;
  CAPTURE(seed);
  Random random(seed);
  const test::TempFolder folder;
  const TriangleMesh<double> ball = sphere_mesh<double>(0.1, 2);
  const std::string originals[] = {write_stl(ball), write_obj(ball)};
  const char* names[] = {"m.stl", "m.obj"};
  constexpr const char* mesh_words[] = {"f 1 2 3\n", "v 1e300 0 0\n",    "v 0 0 0\n",
                                        " 1e-300 ",  "\xff\xff\x7f\x7f", "nan",
                                        "f 1 1 1\n"};
  for (std::size_t kind = 0; kind < 2; ++kind) {
    CAPTURE(names[kind]);
    int loaded = 0;
    const int count = rounds(300);
    for (int round = 0; round < count; ++round) {
      CAPTURE(round);
      write_file(folder.path() / names[kind], damaged(originals[kind], random, mesh_words));
      const std::string mesh = names[kind];
      World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});
      try {
        (void)add_adf<double>(
            world, read_adf("bodies: [A]\nA: {mass: 1, mesh: " + mesh + "}\nsensors: [S]\n" +
                                "S: {type: Resistance, parent: A, range: 0.01, mesh: " + mesh +
                                ", contact stiffness: 1}\n",
                            folder.path() / "scene.yaml"));
        for (int i = 0; i < 3; ++i) world.step();
        ++loaded;
      } catch (const IoError&) {
        CHECK(world.body_count() == 0);
      }
    }
    CHECK(loaded > count / 50);
    CHECK(loaded < count);
  }
}
