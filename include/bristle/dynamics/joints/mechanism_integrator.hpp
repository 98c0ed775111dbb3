/// @file
/// Smooth motion of mechanisms. Joints connect their bodies and nothing else touches them.
///
/// Velocity constraints solved once a step take energy out of everything that swings. They take
/// some tenths of it in a few seconds at usual steps. Without impacts and friction that is not
/// needed. The motion is an ordinary differential equation. At each instant accelerations and joint
/// wrenches follow from
///
///   M a = f + J^T x,   J a = -J' v        (gyroscopic torques and springs are in f)
///
/// A Runge-Kutta method of fifth order integrates them over the step. Its error sets the number of
/// substeps. It leaves small gaps and velocities across the joints. One projection each closes
/// them, the shortest in the metric of the masses.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/joints/joint_projection.hpp>
#include <bristle/math/dormand_prince.hpp>
#include <bristle/math/finite.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// The algorithm with its scratch memory. One object serves many groups in turn. It keeps only the
/// order of their joints.
template <Scalar S>
class MechanismIntegrator {
 public:
  /// @param tolerance  [1] Largest velocity error of a substep, in the norm of kinetic energy, > 0.
  ///                   It is relative to the velocities plus their change by forces in the substep.
  ///                   The velocities are seen from the body that carries the mechanism.
  explicit MechanismIntegrator(S tolerance = S(chosen::mechanism_tolerance))
      : tolerance_(tolerance) {
    BRISTLE_ASSERT(tolerance_ > S(0));
  }

  /// Finds the state of one connected group after a step. Joints may start with errors. Impulses
  /// close velocities at the start. Projections close gaps at the end. Motors and limits are
  /// ignored.
  ///
  /// @param end_poses  Of all bodies, like `MechanismBody::center_pose`.
  /// @param impulses  [N s, N m s] On each joint's B about B's joint origin, along world axes.
  /// @return False if the joints cannot be satisfied (dead or infinite masses, gaps that do not
  ///         close, numbers that are not finite). Also false if substeps ran out. Nothing is then
  ///         written.
  [[nodiscard]] bool advance(std::span<const MechanismBody<S>> bodies,
                             std::span<const MechanismJoint<S>> joints, S dt,
                             std::span<Transform<S>> end_poses, std::span<Twist<S>> end_twists,
                             std::span<Wrench<S>> impulses);

  /// Evaluations of the accelerations in the last call.
  [[nodiscard]] int evaluations() const { return evaluations_; }
  /// Substeps tried in the last call, including rejected ones. It is 0 if accelerations were
  /// constant.
  [[nodiscard]] int substeps() const { return substeps_; }

  // Interface for `DormandPrince`.
  bool derivative(S t, const S* y, S* dy);
  [[nodiscard]] S error_ratio(const S* y, const S* error, S h);

 private:
  /// Writes a vector to consecutive numbers. Returns the place after them.
  template <typename Vector>
  static S* put(const Vector& v, S* to) {
    return std::copy_n(v.data(), int{Vector::SizeAtCompileTime}, to);
  }

  using Node = typename JointSystem<S>::Node;
  static constexpr std::size_t body_values = 13;  // Position, quaternion, velocity, turning.
  static constexpr std::size_t joint_values = 6;  // Impulse and angular impulse.

  [[nodiscard]] bool has_springs() const {
    return std::any_of(system_.joints().begin(), system_.joints().end(),
                       [](const MechanismJoint<S>& joint) { return joint.has_spring(); });
  }
  void choose_reference();
  [[nodiscard]] bool find_held();
  void start_springs();
  void add_springs(S t);
  void accelerate(S t);
  bool move_straight(S dt);
  bool integrate(S dt);
  void advance_driven(S t);
  void read_values(const S* y);
  [[nodiscard]] bool write(std::span<Transform<S>> end_poses, std::span<Twist<S>> end_twists,
                           std::span<Wrench<S>> impulses) const;

  S tolerance_;
  JointSystem<S> system_;
  JointProjection<S> projection_;
  DormandPrince<S> integrator_;
  DynamicArray<S> values_;
  DynamicArray<Twist<S>> wanted_;  // Relative motion of each joint for `solve`.
  DynamicArray<Wrench<S>> impulses_;
  DynamicArray<Wrench<S>> springs_;  // On B about B's joint origin; empty if there are none.
  DynamicArray<S> spring_rates_;     // Rates of the free axes at the start.
  DynamicArray<bool> cannot_turn_;
  Vec3<S> reference_velocity_ = zero<Vec3<S>>();
  Vec3<S> reference_point_ = zero<Vec3<S>>();
  S free_acceleration_ = S(0);  // In the norm of the masses, of the last evaluation.
  bool is_free_ = false;        // Only its loads act on the group from outside.
  bool is_damped_ = false;      // The velocity of one of the bodies decays.
  int evaluations_ = 0;
  int substeps_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
bool MechanismIntegrator<S>::advance(std::span<const MechanismBody<S>> bodies,
                                     std::span<const MechanismJoint<S>> joints, S dt,
                                     std::span<Transform<S>> end_poses,
                                     std::span<Twist<S>> end_twists,
                                     std::span<Wrench<S>> impulses) {
  evaluations_ = 0;
  substeps_ = 0;
  system_.set(bodies, joints);
  wanted_.resize(joints.size());
  impulses_.assign(joints.size(), Wrench<S>{});
  is_damped_ = false;
  for (const MechanismBody<S>& body : bodies) {
    is_damped_ = is_damped_ || is_damped(body);
  }
  is_free_ = !is_damped_;
  for (const MechanismBody<S>& body : bodies) {
    const LockedAxes& locked = body.locked;
    is_free_ = is_free_ && body.moves_by_forces && !locked.any_angular() && !locked.linear[0] &&
               !locked.linear[1] && !locked.linear[2];
  }
  choose_reference();
  start_springs();
  const bool has_constant_loads = springs_.empty() && !is_damped_;
  const bool moved = has_constant_loads && find_held() ? move_straight(dt) : integrate(dt);
  return moved && write(end_poses, end_twists, impulses);
}

/// Chooses the velocity that errors are relative to. It is that of the body that carries the
/// mechanism. So a crane on a ship is as accurate as one on land. Without a carrier it is that of
/// the group's centre of mass.
template <Scalar S>
void MechanismIntegrator<S>::choose_reference() {
  set_zero(reference_velocity_);
  set_zero(reference_point_);
  S weight = S(0);
  const auto add = [&](S mass, const Vec3<S>& point, const Vec3<S>& velocity) {
    weight += mass;
    reference_point_ += mass * point;
    reference_velocity_ += mass * velocity;
  };
  const auto nodes = system_.nodes();
  if (is_free_) {
    for (const Node& node : nodes) add(node.def->mass, node.now.x, node.now.twist.linear);
  } else {
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      const MechanismJoint<S>& joint = system_.joints()[i];
      const Node& a = nodes[joint.body_a];
      const Node& b = nodes[joint.body_b];
      const JointState<S>& at = system_.at(i);
      if (!a.def->moves_by_forces) add(S(1), a.now.x, a.now.twist.at(at.arm_a));
      if (!b.def->moves_by_forces) add(S(1), b.now.x, b.now.twist.at(at.arm_b));
    }
  }
  if (weight > S(0)) {
    reference_point_ /= weight;
    reference_velocity_ /= weight;
  }
}

/// Returns whether no body can turn. Then all axes of each body are locked, or joints without
/// rotation connect it to one that does not turn. Directions are then constant. So are arms as far
/// as they affect linear accelerations: fingers on slides.
template <Scalar S>
bool MechanismIntegrator<S>::find_held() {
  const auto nodes = system_.nodes();
  cannot_turn_.assign(nodes.size(), false);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const MechanismBody<S>& body = *nodes[i].def;
    const auto& locked = body.locked.angular;
    const bool is_locked = !body.moves_by_forces || (locked[0] && locked[1] && locked[2]);
    cannot_turn_[i] = is_locked && body.twist.angular == zero<Vec3<S>>();
  }
  // Each round but the last finds another body that cannot turn.
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (const MechanismJoint<S>& joint : system_.joints()) {
      if (lets_turn(joint.kind) || lets_hinge(joint.kind) ||
          cannot_turn_[joint.body_a] == cannot_turn_[joint.body_b]) {
        continue;
      }
      const Node& other = nodes[cannot_turn_[joint.body_a] ? joint.body_b : joint.body_a];
      if (!other.def->moves_by_forces) continue;
      cannot_turn_[joint.body_a] = cannot_turn_[joint.body_b] = true;
      has_changed = true;
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!cannot_turn_[i]) return false;
  }
  return true;
}

/// Advances bodies at constant accelerations. The one evaluation is at their positions in the
/// middle of the step without forces. Torques of moving arms are then right on average.
template <Scalar S>
bool MechanismIntegrator<S>::move_straight(S dt) {
  const auto nodes = system_.nodes();
  for (Node& node : nodes) node.now.x += (dt / S(2)) * node.now.twist.linear;
  system_.place();
  if (!system_.factor()) return false;
  if (projection_.has_open_velocities(system_)) projection_.close_velocities(system_, impulses_);
  accelerate(dt / S(2));
  for (Node& node : nodes) {
    const Vec3<S> gain = dt * node.acceleration.linear;
    node.now.x = node.def->center_pose.translation + dt * (node.now.twist.linear + gain / S(2));
    node.now.twist.linear += gain;
    set_zero(node.now.twist.angular);
  }
  for (std::size_t i = 0; i < impulses_.size(); ++i) {
    impulses_[i] += dt * system_.wrenches()[i];
  }
  system_.place();
  if (!projection_.close_gaps(system_)) return false;
  projection_.close_velocities(system_, impulses_);
  return true;
}

template <Scalar S>
bool MechanismIntegrator<S>::integrate(S dt) {
  const auto nodes = system_.nodes();
  if (projection_.has_open_velocities(system_)) {
    if (!system_.factor()) return false;
    projection_.close_velocities(system_, impulses_);
  }
  std::size_t state = 0;
  for (const Node& node : nodes) state += node.def->moves_by_forces ? body_values : 0;
  values_.assign(state + joint_values * impulses_.size() + 3, S(0));
  S* y = values_.data();
  for (const Node& node : nodes) {
    if (!node.def->moves_by_forces) continue;
    const BodyState<S>& now = node.now;
    y = put(now.x, y);
    y = put(now.q.coeffs(), y);
    y = put(now.twist.linear, y);
    y = put(now.twist.angular, y);
  }
  Wrench<S> wanted;
  if (is_free_) wanted = momentum_about(reference_point_, system_);

  const bool arrived =
      integrator_.advance(values_, state, dt, *this, chosen::most_mechanism_substeps);
  substeps_ = integrator_.substeps();
  if (!arrived) return false;

  // The last evaluation was at the end. So its matrix can be used.
  read_values(values_.data());
  advance_driven(dt);
  for (std::size_t i = 0; i < impulses_.size(); ++i) {
    const S* impulse = values_.data() + state + joint_values * i;
    impulses_[i].force += Vec3<S>(impulse[0], impulse[1], impulse[2]);
    impulses_[i].torque += Vec3<S>(impulse[3], impulse[4], impulse[5]);
  }
  if (!projection_.close_gaps(system_)) return false;
  projection_.close_velocities(system_, impulses_);
  if (is_free_) {
    for (const Node& node : nodes) wanted.force += dt * node.def->load.force;
    const S* turned = values_.data() + values_.size() - 3;
    wanted.torque += Vec3<S>(turned[0], turned[1], turned[2]);
    set_momentum(reference_point_, wanted, system_);
  }
  return true;
}

/// Poses of the bodies that forces do not move, after a time t.
template <Scalar S>
void MechanismIntegrator<S>::advance_driven(S t) {
  for (Node& node : system_.nodes()) {
    if (node.def->moves_by_forces) continue;
    const Twist<S>& twist = node.def->twist;
    node.now.x = node.def->center_pose.translation + t * twist.linear;
    if (twist.angular == zero<Vec3<S>>()) continue;
    node.now.set_axes(step_rotation(node.def->center_pose.rotation, twist.angular, t));
  }
}

template <Scalar S>
void MechanismIntegrator<S>::read_values(const S* y) {
  for (Node& node : system_.nodes()) {
    if (!node.def->moves_by_forces) continue;
    node.now.x = Vec3<S>(y[0], y[1], y[2]);
    node.now.set_axes(Quat<S>(y[6], y[3], y[4], y[5]));
    node.now.twist = {Vec3<S>(y[7], y[8], y[9]), Vec3<S>(y[10], y[11], y[12])};
    y += body_values;
  }
}

template <Scalar S>
void MechanismIntegrator<S>::start_springs() {
  springs_.clear();
  if (!has_springs()) return;
  const auto joints = system_.joints();
  springs_.resize(joints.size());
  spring_rates_.resize(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    spring_rates_[i] = axis_rate(system_.at(i), system_.nodes()[joints[i].body_a].now.twist,
                                 system_.nodes()[joints[i].body_b].now.twist);
  }
}

/// Sets `Node::load` to loads and spring forces at a time t into the step. Does nothing without
/// springs.
template <Scalar S>
void MechanismIntegrator<S>::add_springs(S t) {
  if (springs_.empty()) return;
  const auto nodes = system_.nodes();
  for (Node& node : nodes) node.load = node.def->load;
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const MechanismJoint<S>& joint = system_.joints()[i];
    if (!joint.has_spring()) continue;
    const JointState<S>& at = system_.at(i);
    Node& a = nodes[joint.body_a];
    Node& b = nodes[joint.body_b];
    // The rate at the start tells whole turns apart.
    const S guess = joint.angle + t * spring_rates_[i];
    const S pull = -joint.spring.stiffness *
                       (axis_position(joint, at, a.now, b.now, guess) - joint.spring.rest) -
                   joint.spring.damping * axis_rate(at, a.now.twist, b.now.twist);
    springs_[i] = {pull * at.slide, pull * at.hinge};
    b.load += Wrench<S>{springs_[i].force, springs_[i].torque + at.arm_b.cross(springs_[i].force)};
    a.load += -Wrench<S>{springs_[i].force, springs_[i].torque + at.arm_a.cross(springs_[i].force)};
  }
}

/// Finds accelerations of all bodies and wrenches of all joints. It uses the present positions, a
/// time t into the step.
template <Scalar S>
void MechanismIntegrator<S>::accelerate(S t) {
  using std::sqrt;
  ++evaluations_;
  add_springs(t);
  S norm2 = S(0);
  for (Node& node : system_.nodes()) {
    if (!node.def->moves_by_forces) continue;
    Wrench<S> load = springs_.empty() ? node.def->load : node.load;
    const Mat3<S>& R = node.now.R;
    const Vec3<S>& w = node.now.twist.angular;
    const Vec3<S> L_B = node.def->inertia_B * Vec3<S>(R.transpose() * w);
    const Vec3<S> L_W = R * L_B;
    if (is_damped_) {
      load.force -= node.def->linear_damping * node.def->mass * node.now.twist.linear;
      load.torque -= node.def->angular_damping * L_W;
    }
    const Vec3<S> torque = load.torque - w.cross(L_W);
    node.acceleration.linear = cwise_product(node.inverse_mass, load.force);
    node.acceleration.angular = node.inverse_inertia * torque;
    norm2 += load.force.dot(node.acceleration.linear) + torque.dot(node.acceleration.angular);
  }
  free_acceleration_ = sqrt(norm2);
  const auto nodes = system_.nodes();
  for (std::size_t i = 0; i < wanted_.size(); ++i) {
    const MechanismJoint<S>& joint = system_.joints()[i];
    wanted_[i] = Twist<S>{} - system_.held(i, [](const Node& node) -> const Twist<S>& {
      return node.acceleration;
    });
    wanted_[i] = wanted_[i] - constraint_acceleration_bias(joint.kind, system_.at(i),
                                                           nodes[joint.body_a].now.twist,
                                                           nodes[joint.body_b].now.twist);
  }
  system_.solve(wanted_);
  for (Node& node : system_.nodes()) node.acceleration = node.acceleration + node.change;
}

template <Scalar S>
bool MechanismIntegrator<S>::derivative(S t, const S* y, S* dy) {
  read_values(y);
  advance_driven(t);
  system_.place();
  if (!system_.factor()) return false;
  accelerate(t);
  Vec3<S> torque = zero<Vec3<S>>();
  for (const Node& node : system_.nodes()) {
    if (!node.def->moves_by_forces) continue;
    const Vec3<S> w = node.now.twist.angular / S(2);
    const S q0 = node.now.q.w();
    const Vec3<S> q = node.now.q.vec();
    dy = put(node.now.twist.linear, dy);
    dy = put(Vec3<S>(q0 * w + w.cross(q)), dy);
    *dy++ = -w.dot(q);
    dy = put(node.acceleration.linear, dy);
    dy = put(node.acceleration.angular, dy);
    const Wrench<S>& load = node.def->load;
    torque += load.torque + (node.now.x - reference_point_).cross(load.force);
  }
  for (std::size_t i = 0; i < impulses_.size(); ++i) {
    Wrench<S> wrench = system_.wrenches()[i];
    if (!springs_.empty()) wrench += springs_[i];
    dy = put(wrench.force, dy);
    dy = put(wrench.torque, dy);
  }
  put(torque, dy);
  return true;
}

template <Scalar S>
S MechanismIntegrator<S>::error_ratio(const S*, const S* error, S h) {
  using std::max;
  using std::sqrt;
  const auto norm2 = [](const Node& node, const Vec3<S>& v, const Vec3<S>& w) {
    const Vec3<S> w_B = node.now.R.transpose() * w;
    return node.def->mass * v.squaredNorm() + w_B.dot(node.def->inertia_B * w_B);
  };
  const S round_off = Tolerance<S>::round_off();
  S error2 = S(0), seen2 = S(0), total2 = S(0);
  for (const Node& node : system_.nodes()) {
    if (!node.def->moves_by_forces) continue;
    const Vec3<S> error_v(error[7], error[8], error[9]);
    const Vec3<S> error_w(error[10], error[11], error[12]);
    error += body_values;
    const Twist<S>& twist = node.now.twist;
    error2 += norm2(node, error_v, error_w);
    seen2 += norm2(node, twist.linear - reference_velocity_, twist.angular);
    total2 += norm2(node, twist.linear, twist.angular);
  }
  if (error2 == S(0)) return S(0);
  // The tolerance is not below the round-off of accelerations and of the speeds themselves.
  return sqrt(error2) / (max(tolerance_, round_off) * (sqrt(seen2) + h * free_acceleration_) +
                         round_off * sqrt(total2));
}

template <Scalar S>
bool MechanismIntegrator<S>::write(std::span<Transform<S>> end_poses,
                                   std::span<Twist<S>> end_twists,
                                   std::span<Wrench<S>> impulses) const {
  // The squares, too: what follows squares velocities, and divides impulses by the step.
  for (const Node& node : system_.nodes()) {
    if (!all_finite(node.now.q.coeffs()) || !has_finite_square<S>(node.now.x) ||
        !has_finite_square<S>(node.now.twist)) {
      return false;
    }
  }
  for (const Wrench<S>& impulse : impulses_) {
    if (!has_finite_square<S>(impulse.force) || !has_finite_square<S>(impulse.torque)) return false;
  }
  for (std::size_t i = 0; i < end_poses.size(); ++i) {
    const Node& node = system_.nodes()[i];
    end_poses[i] = {node.now.q.normalized(), node.now.x};
    end_twists[i] = node.now.twist;
  }
  std::copy(impulses_.begin(), impulses_.end(), impulses.begin());
  return true;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
