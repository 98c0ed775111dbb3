/// @file
/// Conjugate gradients over sweeps: a pair of sweeps finds a direction, and the bodies go along it
/// as far as their energy falls.
///
/// A sweep brings each contact to its law with the others held still. The motion of a heap as a
/// whole, as when a column leans, would take thousands of them. As long as no contact opens or
/// slides, the impulses x minimise the energy
///     f(x) = x'Wx / 2 + q'x.
/// A sweep there and back changes x by d = -M^-1 grad f. M is nearly symmetric: the points of a
/// manifold are solved in the same order there and back. So it serves conjugate gradients (Hestenes
/// and Stiefel 1952) as a preconditioner, each direction conjugate to the last: f is minimised in
/// the plane of d and of the last direction p. That needs no W. The slope of f along d is the sum
/// of d times what velocities lack. d'Wd is twice the kinetic energy of the velocities that d adds.
///
/// Where contacts open or slide, the laws hold sweeps back, and f may rise along d. Such a change
/// says nothing of the next one. Nothing is extrapolated then, and p is forgotten. The same holds
/// where the plane has little to offer: sweeps alone do as well.
///
/// Silcowitz, Niebe and Erleben ("A nonsmooth nonlinear conjugate gradient method for interactive
/// contact force problems", The Visual Computer 2010) forget p where d grows, and go along it by a
/// length that does not ask for the energy. docs/measurements/0021-large-islands.md compares both.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/manifold_block.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/simd.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Extrapolates the impulses of one problem, and the velocities that follow from them. Either may
/// stand for displacements.
///
/// Impulses are shown by functions. They are called with `use`. They call it for each row of
/// impulses, always in the same order.
template <Scalar S>
class SweepExtrapolation {
 public:
  using Row = std::array<S, lanes<S>>;

  /// Reads masses and moments of inertia.
  /// @param slots  [-] Slots of the bodies, in the order of their velocities.
  void read_masses(std::span<const std::uint32_t> slots, std::span<const SolverBody<S>> bodies);

  /// Starts a problem.
  /// @param velocities     Rows of all bodies (`VelocityTable`).
  /// @param show_impulses  Shows rows: use(impulses).
  template <typename ShowImpulses>
  void start(std::span<const S> velocities, ShowImpulses&& show_impulses);

  /// Moves on along the direction of the last pair of sweeps. The result may violate the laws
  /// of contacts. One more sweep restores them.
  /// @param show_residuals  Shows rows and what their velocities lack: use(impulses, residuals).
  /// @return True if it has moved on.
  template <typename ShowResiduals, typename ShowImpulses>
  bool move_on(std::span<S> velocities, ShowResiduals&& show_residuals,
               ShowImpulses&& show_impulses);

 private:
  using T = Pack<S>;
  static constexpr std::size_t stride = VelocityTable<S>::stride;
  /// Numbers of a problem, each with its value after the last pair of sweeps, its change in this
  /// one, and the last direction.
  struct Path {
    DynamicArray<S> before, change, direction;

    void resize(std::size_t size) {
      for (auto* numbers : {&before, &change, &direction}) numbers->resize(size);
    }
  };
  struct Mass {
    S mass;
    std::array<S, 6> inertia;  // The upper part, by rows.
  };
  /// Where the least energy in the plane of the change d and the last direction p is. It is at
  /// `last` times p, and at `along` times d - turn p, which is conjugate to p.
  struct Step {
    S along, turn, last;
    S gain;  // [J] The energy that it takes.
  };

  /// Twice the kinetic energy of velocities, if both are the same.
  [[nodiscard]] S energy(std::span<const S> v, std::span<const S> w) const;
  /// @param whole              [J] d'Wd.
  /// @param slope, last_slope  [J] Slopes of the energy along d and p.
  [[nodiscard]] Step step_to_least(const S& whole, const S& slope, const S& last_slope) const;
  template <typename ShowImpulses>
  void forget(std::span<const S> velocities, ShowImpulses&& show_impulses);

  Path impulses_, velocities_;
  DynamicArray<Mass> masses_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void SweepExtrapolation<S>::read_masses(std::span<const std::uint32_t> slots,
                                        std::span<const SolverBody<S>> bodies) {
  masses_.clear();
  for (const std::uint32_t slot : slots) {
    const SolverBody<S>& body = bodies[slot];
    const Mat3<S>& I = body.inertia;
    masses_.push_back({body.mass, {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)}});
  }
}

template <Scalar S>
template <typename ShowImpulses>
void SweepExtrapolation<S>::start(std::span<const S> velocities, ShowImpulses&& show_impulses) {
  std::size_t size = 0;
  show_impulses([&](const Row&) { size += lanes<S>; });
  impulses_.resize(size);
  velocities_.resize(velocities.size());
  forget(velocities, show_impulses);
}

template <Scalar S>
template <typename ShowImpulses>
void SweepExtrapolation<S>::forget(std::span<const S> velocities, ShowImpulses&& show_impulses) {
  S* before = impulses_.before.data();
  show_impulses([&](const Row& x) {
    T::load(x.data()).store(before);
    before += lanes<S>;
  });
  for (std::size_t k = 0; k < velocities.size(); ++k) velocities_.before[k] = velocities[k];
  // An island that overflowed must not leave numbers to the next one that are none.
  for (Path* path : {&impulses_, &velocities_}) {
    std::fill(path->direction.begin(), path->direction.end(), S(0));
  }
}

template <Scalar S>
S SweepExtrapolation<S>::energy(std::span<const S> v, std::span<const S> w) const {
  S sum = S(0);
  const S* a = v.data();
  const S* b = w.data();
  for (const Mass& m : masses_) {
    const std::array<S, 6>& I = m.inertia;
    sum += m.mass * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) +
           a[3] * (I[0] * b[3] + I[1] * b[4] + I[2] * b[5]) +
           a[4] * (I[1] * b[3] + I[3] * b[4] + I[4] * b[5]) +
           a[5] * (I[2] * b[3] + I[4] * b[4] + I[5] * b[5]);
    a += stride;
    b += stride;
  }
  return sum;
}

template <Scalar S>
auto SweepExtrapolation<S>::step_to_least(const S& whole, const S& slope, const S& last_slope) const
    -> Step {
  Step step{S(0), S(0), S(0), S(0)};
  S conjugate = whole;
  S conjugate_slope = slope;
  if (last_slope < S(0)) {
    const S shared = energy(velocities_.change, velocities_.direction);
    const S last = energy(velocities_.direction, velocities_.direction);
    if (last > S(0)) {
      step.turn = shared / last;
      step.last = -last_slope / last;
      conjugate -= step.turn * shared;
      conjugate_slope -= step.turn * last_slope;
    }
  }
  if (conjugate > S(0)) step.along = -conjugate_slope / conjugate;
  step.gain = S(-0.5) * (step.last * last_slope + step.along * conjugate_slope);
  return step;
}

template <Scalar S>
template <typename ShowResiduals, typename ShowImpulses>
bool SweepExtrapolation<S>::move_on(std::span<S> velocities, ShowResiduals&& show_residuals,
                                    ShowImpulses&& show_impulses) {
  T slope = S(0);
  T last_slope = S(0);
  std::size_t at = 0;
  show_residuals([&](const Row& x, const T& lack) {
    const T change = T::load(x.data()) - T::load(&impulses_.before[at]);
    change.store(&impulses_.change[at]);
    slope += change * lack;
    last_slope += T::load(&impulses_.direction[at]) * lack;
    at += lanes<S>;
  });
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    velocities_.change[k] = velocities[k] - velocities_.before[k];
  }
  const S slope_along = sum_of_lanes(slope);
  const S whole = energy(velocities_.change, velocities_.change);
  const Step step = step_to_least(whole, slope_along, sum_of_lanes(last_slope));
  const S gain_of_sweeps = S(0.5) * whole - slope_along;
  // The energy of bodies that are pressed from two sides falls without end. So no step takes more
  // than there is. In this order a number that is NaN ends it.
  if (!(slope_along < S(0) && step.gain > S(chosen::least_extrapolation_gain) * gain_of_sweeps &&
        step.gain <= S(0.5) * energy(velocities, velocities))) {
    forget(velocities, show_impulses);
    return false;
  }
  at = 0;
  show_impulses([&](Row& x) {
    const T last = T::load(&impulses_.direction[at]);
    const T along = T::load(&impulses_.change[at]) - T(step.turn) * last;
    const T next = T::load(x.data()) + (T(step.last) * last + T(step.along) * along);
    next.store(x.data());
    next.store(&impulses_.before[at]);
    along.store(&impulses_.direction[at]);
    at += lanes<S>;
  });
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    const S last = velocities_.direction[k];
    const S along = velocities_.change[k] - step.turn * last;
    velocities[k] += step.last * last + step.along * along;
    velocities_.before[k] = velocities[k];
    velocities_.direction[k] = along;
  }
  return true;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
