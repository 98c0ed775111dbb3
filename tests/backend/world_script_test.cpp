// The scripts of the fuzzer in tests/fuzz, without one: those that are kept, and random ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/world_script.hpp"

#include "support/rounds.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::test;

namespace {

ScriptCounts run(const std::vector<std::uint8_t>& bytes) {
  try {
    return run_world_script(bytes);
  } catch (const Finding& finding) {
    FAIL_CHECK(std::string(finding.what()));
    return {};
  }
}

}  // namespace

TEST_CASE("world_script: calls that are kept hold what is promised") {
  std::size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(BRISTLE_CORPUS_DIR "/world")) {
    CAPTURE(file.path().filename().string());
    std::ifstream stream(file.path(), std::ios::binary);
    const std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(stream)), {});
    CHECK(run(bytes).calls > 0);
    ++files;
  }
  CHECK(files > 0);
}

TEST_CASE("world_script: random calls hold what is promised") {
  std::mt19937_64 random(1);
  ScriptCounts all;
  for (int round = 0; round < rounds(2000); ++round) {
    CAPTURE(round);
    std::vector<std::uint8_t> bytes(200 + random() % 1000);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 56);
    bytes[0] = static_cast<std::uint8_t>(round);
    const ScriptCounts counts = run(bytes);
    all.calls += counts.calls;
    all.refused += counts.refused;
    all.steps += counts.steps;
  }
  // Both what is refused and what is not.
  CHECK(all.refused > all.calls / 10);
  CHECK(all.refused < all.calls * 9 / 10);
  CHECK(all.steps > all.calls / 10);
}
