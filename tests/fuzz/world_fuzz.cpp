// libFuzzer: bytes as calls of a world (tests/fuzz/world_script.hpp).
// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/world_script.hpp"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    (void)bristle::test::run_world_script(std::span(data, size));
  } catch (const bristle::test::Finding& finding) {
    std::fprintf(stderr, "FINDING: %s\n", finding.what());
    std::abort();
  }
  return 0;
}
