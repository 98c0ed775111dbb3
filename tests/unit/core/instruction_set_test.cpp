// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/error.hpp>
#include <bristle/core/instruction_set.hpp>
#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

using namespace bristle;

TEST_CASE("instruction_set: a set that is there is pinned, and one that is not is refused") {
  const InstructionSet before = instruction_set();
  for (const InstructionSet set :
       {InstructionSet::baseline, InstructionSet::v3, InstructionSet::v4}) {
    CAPTURE(std::string(name_of(set)));
    const InstructionSet last = instruction_set();
    try {
      set_instruction_set(set);
      CHECK(instruction_set() == set);
      CHECK(set <= widest_instruction_set());
    } catch (const InvalidArgument& error) {
      CHECK(error.value() == name_of(set));
      CHECK(instruction_set() == last);
      CHECK(set > InstructionSet::baseline);
    }
  }
  set_instruction_set(before);
}

// Run by itself with BRISTLE_INSTRUCTION_SET=none (tests/CMakeLists.txt).
TEST_CASE("instruction_set: an environment that asks for what is none is refused, a call is not") {
  const char* wanted = std::getenv("BRISTLE_INSTRUCTION_SET");
  if (wanted == nullptr || std::string(wanted) != "none") return;
  CHECK_THROWS_AS((void)instruction_set(), InvalidArgument);
  CHECK_THROWS_AS((void)instruction_set(), InvalidArgument);
  set_instruction_set(InstructionSet::baseline);
  CHECK(instruction_set() == InstructionSet::baseline);
}
