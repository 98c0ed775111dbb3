/// @file
/// The instruction sets that `bristle::compiled` has its kernels in, and which of them is used.
///
/// The library chooses when a program runs: the widest registers that the processor has, unless the
/// environment variable BRISTLE_INSTRUCTION_SET (`baseline`, `v3`, `v4`) or a call says otherwise.
/// Last bits depend on the choice: sums over sensors are made lane by lane, and Eigen's dot products
/// in the order that its registers suggest. Pin it where runs on different machines are compared.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

/// Instruction sets by the levels of the x86-64 psABI; other processors have the baseline alone.
enum class InstructionSet : std::uint8_t {
  /// What every processor of its kind has: SSE2 on x86-64, NEON on ARM. Registers of 16 bytes.
  baseline,
  /// x86-64-v3: AVX2 and FMA. Registers of 32 bytes.
  v3,
  /// x86-64-v4: AVX-512. Registers of 64 bytes.
  v4
};

/// `baseline`, `v3` or `v4`.
[[nodiscard]] constexpr std::string_view name_of(InstructionSet set) {
  constexpr std::string_view names[] = {"baseline", "v3", "v4"};
  return names[static_cast<std::size_t>(set)];
}

#if defined(BRISTLE_COMPILED)
/// The widest that this processor has and the library was built with.
[[nodiscard]] InstructionSet widest_instruction_set() noexcept;
/// The one that worlds, haptic loops and host patches use which are made from here on.
/// @throws InvalidArgument when the environment asks for one that this processor or this build of
///         the library has not got, or for something else, and no call has pinned one.
[[nodiscard]] InstructionSet instruction_set();
/// Pins it for all that is made from here on, whatever the environment says; what exists keeps what
/// it has.
/// @throws InvalidArgument when this processor or this build of the library has not got it.
void set_instruction_set(InstructionSet set);
#endif

}  // namespace bristle::inline BRISTLE_ABI
