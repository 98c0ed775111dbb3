/// @file
/// Constants of the solver of islands that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

// Regularisation eps of rows ----------------------------------------------------------------------

/// [1] Least eps of a row, and the eps of joints. A smaller one shows round-off of the stiffness
/// M^-1 J^T J / eps. A greater one needs more moves of the centre. Joints with 1e-4 left 38 sweeps
/// a step to hands (docs/measurements/0034-newton-on-coulombs-law.md).
inline constexpr double least_eps = 1e-6;

// Newton's method on Coulomb's law (coulomb_newton.hpp) -------------------------------------------

/// [1] Residual that is good enough, as a share of the slip or of the velocity change by forces. A
/// smaller share takes more steps. A hundredth took 10 to 20 % less time, with ten times the error
/// (docs/measurements/0042-a-budget-for-an-island.md).
inline constexpr double good_enough_share = 1e-3;

/// [1] First eps where surfaces slide. A smaller one leaves the branches of the law from far away.
/// A greater one takes more factorisations. One eps of 1e-3 at every start fails twice as often for
/// `topple20` (docs/measurements/0034).
inline constexpr double newton_first_eps = 1e-3;

/// [1] First eps where the warm start gives no hint and the impulses start from zero. A smaller one
/// leads astray. A greater one needs more factorisations on the way to the least eps.
inline constexpr double newton_cold_eps = 1e-2;

/// [1] Largest distance of a warm start from the law, as a multiple of the velocity change by
/// forces. Beyond it the method starts from no impulses. A smaller one forgets loads that are
/// nearly right. A greater one keeps impulses of impacts.
inline constexpr double far_start_ratio = 3.0;

/// [1] Share of the tolerance up to which a state is steady and needs no factorisation. A greater
/// one lets errors of resting contacts add up. A smaller one factorises islands at rest.
inline constexpr double steady_share = 1e-2;

/// [1] Share of the residual before at which a step still gains cheaply. Good enough results are
/// improved by such steps. Without them belts that hold boxes took a solve in every step, 0.93 ms
/// (docs/measurements/0042). A greater share takes more steps.
inline constexpr double cheap_gain_share = 0.1;

/// [1] Growth of the distance from the law at which a step is taken back. A smaller one takes back
/// steps that would have recovered. A greater one follows steps that lead away. Tenfold was part of
/// a variant that made chains faster and toppling rows slower (docs/measurements/0034).
inline constexpr double rejected_growth = 3.0;

/// [1] Factor of eps after a step that was taken back. A smaller one is taken back more often. A
/// greater one holds light bodies back: rows of balls kept 0.12 to 0.39 m/s with 1e-3 at once
/// (docs/measurements/0042).
inline constexpr double rejected_eps_growth = 10.0;

/// [1] Largest eps from which a step can still be taken back. A greater one spends steps on what is
/// not near. A smaller one gives up where a softer step would have led on.
inline constexpr double largest_eps = 0.1;

/// [1] Share of the distance before that a step with an old factor may leave. Above it the matrix
/// is factored anew. A smaller share factors more often. A greater one takes more steps that gain
/// little.
inline constexpr double stale_factor_share = 0.1;

/// [1] Share of the tolerance, or of the residual, at which the problem with one centre is solved.
/// A smaller one takes steps that the next centre undoes. A greater one moves the centre early:
/// half was part of a variant that made chains faster and drums slower (docs/measurements/0034).
inline constexpr double centre_solved_share = 0.1;

/// [1] Residual that a new centre may leave, as a share of that before. Above it rows contradict
/// each other, or the search has stalled. A smaller one gives up early. A greater one moves centres
/// in vain.
inline constexpr double stalled_centre_share = 0.5;

/// [1] Share of the residual before at which a centre converges fast. Eps and its factor are then
/// kept. A smaller one factors for a smaller eps more often. A greater one takes more centres.
inline constexpr double fast_centre_share = 0.03;

/// [1] Factor of eps from one centre to the next. A smaller one leaves the branches of the law. A
/// greater one takes more factorisations: a third gained nothing that is not lost elsewhere
/// (docs/measurements/0034).
inline constexpr double newton_eps_decrease = 0.1;

/// [-] Most Newton steps of one solve. A smaller bound ends impacts that pass through rows of
/// contacts: 16 equal balls need 16 steps (docs/measurements/0042). A greater one spends time on
/// what is not near.
inline constexpr int most_newton_steps_of_law = 30;

// Interior-point method (interior_point.hpp) ------------------------------------------------------

/// [1] Share of the way to the boundary of the cones that a step takes at most. A smaller one takes
/// more steps. A greater one comes so near to the boundary that later steps are short.
inline constexpr double boundary_share = 0.99;

/// [1] Velocity that a row yields per impulse, as a share of its response. It keeps the matrix
/// regular where rows are redundant. It moves with the impulses and leaves no trace. A smaller one
/// lets round-off decide. With 1e-6 redundant impulses are held back on their way to the middle,
/// and a third of the presses fail (docs/decisions/0056-an-interior-point-is-the-harbour.md).
inline constexpr double interior_yield = 1e-10;

/// [1] Residual at which Newton's method takes over, as a share of the velocity change by forces. A
/// smaller one spends steps at the edges of the cones. A greater one starts Newton's method from
/// farther away.
inline constexpr double interior_solved_share = 1e-5;

// Proximal iteration (proximal_solver.hpp) --------------------------------------------------------

/// [1] Share of the velocity tolerance to which factorisations solve an island. A sweep over the
/// result then finds nothing to do. A smaller one takes more steps. A greater one takes more sweeps
/// in the next step.
inline constexpr double direct_tolerance_share = 0.1;

/// [1] The same for islands that are swept first in the next step. Their sweeps end after one if
/// little is left. A smaller one asks for round-off. A greater one factorises the next step, too.
inline constexpr double swept_first_tolerance_share = 0.01;

/// [-] Newton steps on Coulomb's law from no impulses. Landings that do not jam take one or two.
/// Fewer steps send landings to the interior point. More are lost where bodies jam.
inline constexpr int most_landing_steps = 4;

/// [1] Softness of the springs that hold joints in the test for locked rows, as a share of a row's
/// response. It is far below `locked_response_share`. A greater one lets locked rows respond. A
/// smaller one drowns in round-off (docs/decisions/0009-locked-contact-directions.md).
inline constexpr double joint_spring_softness = 1e-9;

/// [1] Response with joints held, as a share of that without them, below which a row is locked. A
/// smaller one tears fingers off their slides. A greater one drops contacts of heavy bodies that
/// joints hold: a millionth needs a mass ratio of a million (docs/decisions/0009).
inline constexpr double locked_response_share = 1e-6;

/// [1] First eps. A smaller one takes many Newton steps from far away, and 1e-6 does not converge.
/// A greater one takes more outer iterations. 1e-3 saves 40 % of the factorisations of 1e-2
/// (docs/measurements/0019-cones-not-disks.md).
inline constexpr double proximal_first_eps = 1e-3;

/// [1] Divisor of eps from one outer iteration to the next. A smaller one takes more iterations. A
/// greater one starts each Newton search farther away.
inline constexpr double proximal_eps_divisor = 10.0;

/// [1] Residual of the convex problem, as a share of that of the law, at which its opening speeds
/// follow the slip. Shares of 0.03 to 0.5 give the same bits. With 0.8 floors sink by 0.06 um, and
/// without the condition they fall (docs/measurements/0019).
inline constexpr double convex_solved_share = 0.5;

/// [1] Share of the tolerance to which the inner loop solves. A smaller one takes more Newton
/// steps. A greater one keeps the outer loop above its tolerance.
inline constexpr double inner_tolerance_share = 0.1;

/// [1] Share of the last residual to which the inner loop solves. The function changes with the
/// next outer iteration. A smaller one solves it in vain. A greater one slows the outer loop.
inline constexpr double inner_residual_share = 0.01;

/// [-] Outer iterations that run before a stall ends them. Fewer end before eps is least. More cost
/// Newton steps where slip keeps turning.
inline constexpr int least_outer_iterations = 10;

/// [1] Residual, as a share of the one before, above which the outer loop has stalled. A smaller
/// one ends slow convergence. A greater one spends the budget on slip that keeps turning.
inline constexpr double stalled_residual_share = 0.9;

/// [1] Mismatch of impulses and velocities, as a share of the least so far, above which a small
/// Newton step is idle. A smaller one ends while steps still gain. A greater one takes more steps
/// among round-off.
inline constexpr double idle_mismatch_share = 0.5;

/// [-] Idle steps in a row that end the inner loop. One ended it while impulses were off by 374 m/s
/// (docs/measurements/0042, "Longer steps"). More take steps among round-off.
inline constexpr int most_idle_steps = 2;

/// [1] Derivative on the line, as a share of that at its start, at which the line search ends. A
/// smaller one evaluates more. A greater one leaves more to the next Newton step.
inline constexpr double line_search_share = 0.01;

/// [-] Most evaluations of a line search. Fewer end it before its share is reached. More are rarely
/// used, as the Illinois method converges faster than linearly.
inline constexpr int most_line_search_steps = 20;

// Choice between factorisations and sweeps (method_choice.hpp) ------------------------------------

/// [1] `hold_of` an impulse below which a contact is at the edge of its friction cone: a thousandth
/// of its bound. A smaller one takes slip for rest. A greater one takes loads that are shared
/// evenly for slip, and starts Newton's method with more factorisations (docs/decisions/0051).
inline constexpr double edge_hold = 0.01;

/// [-] Multiply-adds of the assembly of one contact row: two lower triangles of 21 and one square
/// of 36 in blocks of six. A smaller number factorises larger heaps. A greater one sweeps smaller
/// ones.
inline constexpr std::uint64_t contact_row_work = 78;

/// [-] Multiply-adds of the assembly of one soft block. A smaller number factorises larger islands
/// with sensors. A greater one sweeps smaller ones.
inline constexpr std::uint64_t soft_block_work = 500;

/// [1] Divisor of `max_direct_work`: sweeps solve heaps that slide and take more work. With 20
/// belts that hold a row back cost 1.15 times as much (docs/measurements/0042, "Heaps that slide").
/// A smaller one factorises more heaps that slide.
inline constexpr std::uint64_t sliding_work_divisor = 10;

/// [1] Divisor of `max_direct_work`: the elimination of islands with mechanisms and contacts takes
/// less, or the island is swept. With 10 and 20 ragdolls passed limits by 0.24 and 0.29 rad, with 5
/// by 0.07. With 3 they took 5.7 ms instead of 2.1 (docs/measurements/0042, "No zero blocks").
inline constexpr std::uint64_t mechanism_work_divisor = 5;

// Budget of an island (solver_types.hpp) ----------------------------------------------------------

/// [-] Factorisations of the largest island whose multiply-adds are the budget of one problem. With
/// a half of it `push24` overlapped by 0.3 mm, and its worst step took 7.8 ms instead of 11.8
/// (docs/measurements/0042). A greater one makes worst steps longer.
inline constexpr double budget_factorisations = 20.0;

/// [-] Problems whose budget all passes of a step share. With one the worst step of `chain100` took
/// 11 ms instead of 22, with gaps of 0.13 mm (docs/measurements/0042). A greater number makes worst
/// steps longer.
inline constexpr int budgets_of_step = 3;

/// [1] Share of the budget up to which an island is cheap and is solved exactly. With a half the
/// worst step of `chain100` took 18.6 ms instead of 7.5. With nothing exact hands took 1.8
/// factorisations for 1.4 (docs/measurements/0042, "From which cost on ...").
inline constexpr double cheap_cost_share = 0.25;

/// [-] Multiply-adds of a contact in a sweep. A smaller number allows more sweeps within the
/// budget. Twice the sweeps of positions halved the overlap of 120 boxes, in 1.45 times the time
/// (docs/measurements/0042, "Larger heaps that slide").
inline constexpr double contact_sweep_work = 100.0;

/// [-] Most sweeps that the budget pays for. With the default budget it binds islands of fewer than
/// 14 contacts. A smaller bound ends their sweeps early. A greater one makes their worst steps
/// longer.
inline constexpr double most_affordable_sweeps = 1e4;

/// [-] Most substeps of a swept island. A smaller number lengthens substeps of long steps. A
/// greater one makes such steps cost more.
inline constexpr int most_swept_substeps = 64;

// Sweeps (island_solver.hpp, sweep_convergence.hpp) -----------------------------------------------

/// [1] Share of the velocity tolerance that sweeps after the first go down to. A greater one lets
/// the residual come up again in the next step. A smaller one takes more sweeps.
inline constexpr double later_sweep_share = 0.3;

/// [1] Residual of positions, as a share of that of velocities, at which they are solved. A pyramid
/// of 210 creeps by 0.29 mm with 0.3, and by 0.97 mm with 1
/// (docs/measurements/0021-large-islands.md). A smaller one takes more sweeps.
inline constexpr double swept_position_share = 0.3;

/// [1] Velocity change of a sweep, as a share of that by forces, below which Newton's method takes
/// over a heap that slides. A greater one gives it heaps that jam, where it fails in 16 of 16
/// steps. A smaller one leaves steady slides to sweeps (docs/decisions/0049).
inline constexpr double newton_takes_over_share = 1e-3;

/// [1] Residual of positions in a heap that slides, as a share of the velocity change by forces.
/// Positions as loose as 0.3 of the residual let `push24` overlap by 64 um instead of 10
/// (docs/measurements/0042). A smaller one takes more sweeps.
inline constexpr double sliding_overlap_share = 3e-2;

/// [1] Divisor of the affordable sweeps: velocities of a heap that slides get that part of them.
/// With half of them 240 boxes overlapped by 54 mm, with ten sweeps by 39, with a quarter by 13
/// (docs/measurements/0042, "Larger heaps that slide").
inline constexpr int sliding_velocity_divisor = 4;

/// [1] Growth of the kinetic energy of a swept substep at which it is swept again from no impulses.
/// A smaller one takes bounces and motors for errors. A greater one keeps energy of warm starts. Of
/// 192 bouncing heaps 37 blew up before this and two other changes (docs/measurements/0021).
inline constexpr double suspicious_energy_growth = 2.0;

/// [-] Sweeps before their rate tells anything. A smaller number factorises what sweeps would have
/// solved. Four to 30 sweeps before Newton's method were no better (docs/measurements/0034).
inline constexpr int least_sweeps_before_rate = 4;

/// [-] Sweeps of contacts that cost as much as one solve by factorisation. That holds for stacks of
/// any height (docs/solver.md). A smaller number factorises sooner. A greater one sweeps longer.
inline constexpr double sweeps_of_direct_solve = 60.0;

// Bound of crushing impulses (crushing_limit.hpp) -------------------------------------------------

/// [1] Load of a contact as a multiple of all that acts on its island in a step. Levers and wedges
/// that are moved against something ask for more than one. Of 96 crushed heaps 2, 1 and 0 throw a
/// cube out with 5, 10 and 20 (docs/measurements/0021-large-islands.md).
inline constexpr double most_leverage = 10.0;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
