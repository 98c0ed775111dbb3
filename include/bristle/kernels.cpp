// World kernels in the scalar BRISTLE_INSTANTIATE. This file is compiled for the instruction set
// BRISTLE_KERNELS.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/kernel_tables.hpp>
#include <bristle/hosts/host_stage.hpp>
#include <bristle/world/kernels_impl.hpp>
#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

extern "C" const bristle::detail::KernelTables* BRISTLE_KERNELS_OF(BRISTLE_INSTANTIATE,
                                                                   BRISTLE_KERNELS)() {
  using S = BRISTLE_INSTANTIATE;
  static const bristle::detail::KernelTables tables {
    .joint = &bristle::detail::own_joint_kernels<S>(),
    .haptic = &bristle::detail::own_haptic_kernels<S>(),
    .host = &bristle::detail::own_host_kernels<S>(),
    .analytic_world = &bristle::detail::own_world_kernels<S, bristle::AnalyticBackend>(),
#if defined(BRISTLE_WITH_FCL)
    .fcl_world = &bristle::detail::own_world_kernels<S, bristle::FclBackend>(),
#endif
  };
  return &tables;
}
