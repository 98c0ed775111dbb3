// Choice of an instruction set, and of the kernels that were compiled for it.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/error.hpp>
#include <bristle/core/instruction_set.hpp>
#include <bristle/core/kernel_tables.hpp>

#include <atomic>
#include <cstdlib>
#include <string>

namespace bristle::inline BRISTLE_ABI {
namespace {

// Clang knows the names of levels from 18 on. Before, their features that it has names for are
// asked: every processor with these has the others of its level, too.
#if defined(__clang__) && __clang_major__ < 18
#define BRISTLE_CPU_IS_V3                                                       \
  (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0 && \
   __builtin_cpu_supports("bmi") != 0 && __builtin_cpu_supports("bmi2") != 0)
#define BRISTLE_CPU_IS_V4                                                                \
  (BRISTLE_CPU_IS_V3 && __builtin_cpu_supports("avx512f") != 0 &&                        \
   __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512cd") != 0 && \
   __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512vl") != 0)
#else
#define BRISTLE_CPU_IS_V3 (__builtin_cpu_supports("x86-64-v3") != 0)
#define BRISTLE_CPU_IS_V4 (__builtin_cpu_supports("x86-64-v4") != 0)
#endif

/// Returns whether the library was built with a set and the processor has it.
bool has(InstructionSet set) noexcept {
  switch (set) {
    case InstructionSet::baseline:
      return true;
#if defined(BRISTLE_KERNELS_V3)
    case InstructionSet::v3:
      return BRISTLE_CPU_IS_V3;
#endif
#if defined(BRISTLE_KERNELS_V4)
    case InstructionSet::v4:
      return BRISTLE_CPU_IS_V4;
#endif
    default:
      return false;
  }
}

constexpr InstructionSet all_sets[] = {InstructionSet::baseline, InstructionSet::v3,
                                       InstructionSet::v4};
constexpr const char* must_be_there = "must be one that this processor and this library have";

/// The choice of the environment, else the widest.
InstructionSet first_choice() {
  const char* wanted = std::getenv("BRISTLE_INSTRUCTION_SET");
  if (wanted == nullptr) return widest_instruction_set();
  for (const InstructionSet set : all_sets) {
    if (name_of(set) == wanted && has(set)) return set;
  }
  detail::raise(InvalidArgument("BRISTLE_INSTRUCTION_SET", wanted, must_be_there));
}

constexpr int none_pinned = -1;
std::atomic<int> pinned{none_pinned};

}  // namespace

InstructionSet widest_instruction_set() noexcept {
  if (has(InstructionSet::v4)) return InstructionSet::v4;
  return has(InstructionSet::v3) ? InstructionSet::v3 : InstructionSet::baseline;
}

InstructionSet instruction_set() {
  const int set = pinned.load(std::memory_order_relaxed);
  if (set != none_pinned) return static_cast<InstructionSet>(set);
  static const InstructionSet first = first_choice();
  return first;
}

void set_instruction_set(InstructionSet set) {
  detail::require_enumerator("InstructionSet", set, InstructionSet::v4);
  if (!has(set)) {
    detail::raise(InvalidArgument("InstructionSet", std::string(name_of(set)), must_be_there));
  }
  pinned.store(static_cast<int>(set), std::memory_order_relaxed);
}

// A set that the library was built without is never chosen.
#if !defined(BRISTLE_KERNELS_V3)
#define bristle_kernels_float_v3 bristle_kernels_float_baseline
#define bristle_kernels_double_v3 bristle_kernels_double_baseline
#endif
#if !defined(BRISTLE_KERNELS_V4)
#define bristle_kernels_float_v4 bristle_kernels_float_baseline
#define bristle_kernels_double_v4 bristle_kernels_double_baseline
#endif

const detail::KernelTables& chosen_kernels_float() {
  constexpr const detail::KernelTables* (*of[])() = {
      bristle_kernels_float_baseline, bristle_kernels_float_v3, bristle_kernels_float_v4};
  return *of[static_cast<std::size_t>(instruction_set())]();
}

const detail::KernelTables& chosen_kernels_double() {
  constexpr const detail::KernelTables* (*of[])() = {
      bristle_kernels_double_baseline, bristle_kernels_double_v3, bristle_kernels_double_v4};
  return *of[static_cast<std::size_t>(instruction_set())]();
}

}  // namespace bristle::inline BRISTLE_ABI
