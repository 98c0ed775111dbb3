/// @file
/// How the compiled library finds the kernels of each instruction set: one plain function for each
/// set and scalar. The objects that define them export nothing else, so that no function which was
/// compiled for wide registers can take the place of one that every processor runs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

/// Name of the function that gives the kernels of a set (`baseline`, `v3`, `v4`) in a scalar, and
/// of the one that gives those of `instruction_set()`.
#define BRISTLE_KERNELS_OF(S, set) BRISTLE_KERNELS_OF_(S, set)
#define BRISTLE_KERNELS_OF_(S, set) bristle_kernels_##S##_##set
#define BRISTLE_CHOSEN_KERNELS(S) BRISTLE_CHOSEN_KERNELS_(S)
#define BRISTLE_CHOSEN_KERNELS_(S) chosen_kernels_##S

namespace bristle::inline BRISTLE_ABI {

/// Addresses of a `WorldKernels`, a `HapticKernels` and a `HostKernels`; null for a backend that the
/// library was built without.
struct BackendTables {
  const void* world = nullptr;
  const void* haptic = nullptr;
  const void* host = nullptr;
};

/// The tables of each backend, in the scalar that the function is named for.
struct KernelTables {
  BackendTables analytic{};
  BackendTables fcl{};
};

extern "C" {
const KernelTables* bristle_kernels_float_baseline();
const KernelTables* bristle_kernels_double_baseline();
const KernelTables* bristle_kernels_float_v3();
const KernelTables* bristle_kernels_double_v3();
const KernelTables* bristle_kernels_float_v4();
const KernelTables* bristle_kernels_double_v4();
}

[[nodiscard]] const KernelTables& chosen_kernels_float();
[[nodiscard]] const KernelTables& chosen_kernels_double();

}  // namespace bristle::inline BRISTLE_ABI
