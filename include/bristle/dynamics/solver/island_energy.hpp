/// @file
/// Kinetic energy of an island, as solved and for comparison.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_types.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// [J] Twice the kinetic energy of an island's bodies.
template <Scalar S>
struct IslandEnergy {
  /// With the solved velocities.
  S found = S(0);
  /// At the start of the step, and at its end in free motion.
  S start = S(0);
  S free = S(0);
};

/// [kg m^2/s^2] Product of two motions of a body in the metric of its mass.
template <Scalar S>
[[nodiscard]] S mass_product(const SolverBody<S>& body, const Twist<S>& u, const Twist<S>& v) {
  return body.mass * u.linear.dot(v.linear) + u.angular.dot(body.inertia * v.angular);
}

/// Computes the energies of an island.
template <Scalar S>
[[nodiscard]] IslandEnergy<S> energy_of(const Island& island,
                                        std::span<const SolverBody<S>> bodies) {
  IslandEnergy<S> sum;
  for (const std::uint32_t slot : island.bodies) {
    const SolverBody<S>& body = bodies[slot];
    sum.found += mass_product(body, body.twist, body.twist);
    sum.start += mass_product(body, body.start, body.start);
    sum.free += mass_product(body, body.free, body.free);
  }
  return sum;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
