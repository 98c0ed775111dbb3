/// @file
/// For headers with mutants: which of them a run switches on, none or one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <string_view>

namespace bristle_mutants {

/// If the environment asks for this mutant: BRISTLE_MUTANT=<name>.
inline bool is_on(std::string_view name) {
  const char* const wanted = std::getenv("BRISTLE_MUTANT");
  return wanted != nullptr && wanted == name;
}

}  // namespace bristle_mutants
