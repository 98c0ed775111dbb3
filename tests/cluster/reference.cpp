// The worlds of examples/cluster one after the other, without MPI and without a batch: prints the
// same last line.
// Usage: cluster_reference WORLDS ROUNDS
// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/grip.hpp"

#include <bristle/bristle.hpp>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <string>

int main(int, char** argv) {
  const std::uint64_t worlds = std::stoull(argv[1]);
  const std::uint64_t rounds = std::stoull(argv[2]);
  const cluster::Grip grip(6);
  std::uint64_t hash = 0;
  for (std::uint64_t number = 0; number < worlds; ++number) {
    cluster::World<float> world = grip.world;
    grip.vary(world, number);
    for (std::uint64_t round = 0; round < rounds; ++round) {
      grip.shake(world, number, round);
      for (std::size_t i = 0; i < cluster::Grip::steps_per_round; ++i) world.step();
    }
    hash = cluster::mixed(hash, world.state_hash());
  }
  std::printf("states %016" PRIx64 "\n", hash);
}
