/// @file
/// Instruction sets of the kernels in `bristle::compiled`, and the choice among them.
///
/// The library chooses when a program runs. It takes the widest registers of the processor. The
/// environment variable BRISTLE_INSTRUCTION_SET (`baseline`, `v3`, `v4`) or a call may choose
/// another set. Last bits of results depend on the choice. Sums over sensors are made lane by lane.
/// Eigen's dot products have an order that its registers suggest. Pin the choice to compare runs on
/// different machines.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

/// Instruction sets by the levels of the x86-64 psABI. Other processors have the baseline alone.
enum class InstructionSet : std::uint8_t {
  /// Instructions that every processor of its kind has: SSE2 on x86-64, NEON on ARM. Registers of
  /// 16 bytes.
  baseline,
  /// x86-64-v3: AVX2 and FMA. Registers of 32 bytes.
  v3,
  /// x86-64-v4: AVX-512. Registers of 64 bytes.
  v4
};

/// Name of a set: `baseline`, `v3` or `v4`.
[[nodiscard]] constexpr std::string_view name_of(InstructionSet set) {
  constexpr std::string_view names[] = {"baseline", "v3", "v4"};
  return names[static_cast<std::size_t>(set)];
}

#if defined(BRISTLE_COMPILED)
/// The widest set that this processor has and the library was built with.
[[nodiscard]] InstructionSet widest_instruction_set() noexcept;
/// The set of worlds, haptic loops and host patches that are made from here on.
/// @throws InvalidArgument if no call has pinned a set and the environment names a bad one. It is
///         unknown, or this processor or this build of the library lacks it.
[[nodiscard]] InstructionSet instruction_set();
/// Pins the set for everything made from here on. The environment no longer counts. Existing
/// objects keep theirs.
/// @throws InvalidArgument if this processor or this build of the library lacks the set.
void set_instruction_set(InstructionSet set);
#endif

}  // namespace bristle::inline BRISTLE_ABI
