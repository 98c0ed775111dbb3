// libFuzzer: bytes as a scene, read and added to a world that takes a step.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf.hpp>

#include <cstddef>
#include <cstdint>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  bristle::AdfBuildDef<double> def;
  def.limits.max_bytes = 1 << 16;
  def.limits.max_items = 100;
  def.limits.max_rays = 1000;
  def.limits.max_mesh_bytes = 1 << 16;
  bristle::World<double> world({.gravity = {0, 0, -9.81}});
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    (void)bristle::add_adf(
        world, bristle::detail::read_adf(text, BRISTLE_SCENES_DIR "/fuzz.yaml", def.limits), def);
    world.step();
  } catch (const bristle::IoError&) {
    // The one thing that bad bytes may do.
  }
  return 0;
}
