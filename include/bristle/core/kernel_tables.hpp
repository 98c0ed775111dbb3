/// @file
/// Access of the compiled library to the kernels of each instruction set. There is one plain
/// function for each set and scalar. The objects that define them export nothing else. So no
/// function compiled for wide registers can replace one that every processor runs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

/// Name of the function that returns the kernels of a set (`baseline`, `v3`, `v4`) in the scalar S.
#define BRISTLE_KERNELS_OF(S, set) BRISTLE_KERNELS_OF_(S, set)
/// Joins the name once the arguments are expanded.
#define BRISTLE_KERNELS_OF_(S, set) bristle_kernels_##S##_##set
/// Name of the function that returns the kernels of `instruction_set()` in the scalar S.
#define BRISTLE_CHOSEN_KERNELS(S) BRISTLE_CHOSEN_KERNELS_(S)
/// Joins the name once the argument is expanded.
#define BRISTLE_CHOSEN_KERNELS_(S) chosen_kernels_##S

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// Addresses of a `JointKernels`, a `HapticKernels`, a `HostKernels`, and of a `WorldKernels` for
/// each backend, in the scalar that the function's name has. `fcl_world` is null in a library that
/// was built without FCL.
struct KernelTables {
  const void* joint = nullptr;
  const void* haptic = nullptr;
  const void* host = nullptr;
  const void* analytic_world = nullptr;
  const void* fcl_world = nullptr;
};

}  // namespace detail

extern "C" {
/// Kernels of the set and scalar in the name. Call those of a set only on a processor that has it.
/// @{
const detail::KernelTables* bristle_kernels_float_baseline();
const detail::KernelTables* bristle_kernels_double_baseline();
const detail::KernelTables* bristle_kernels_float_v3();
const detail::KernelTables* bristle_kernels_double_v3();
const detail::KernelTables* bristle_kernels_float_v4();
const detail::KernelTables* bristle_kernels_double_v4();
/// @}
}

/// Kernels of `instruction_set()` in the scalar of the name.
/// @{
[[nodiscard]] const detail::KernelTables& chosen_kernels_float();
[[nodiscard]] const detail::KernelTables& chosen_kernels_double();
/// @}

}  // namespace bristle::inline BRISTLE_ABI
