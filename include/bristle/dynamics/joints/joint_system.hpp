/// @file
/// Bodies held by joints at one instant. They respond to impulses, forces and each other.
///
/// Let J be the rows of all joints (joint_kinematics.hpp) and M the masses. The wrenches that give
/// the joints a relative motion b solve K x = b, K = J M^-1 J^T. Two joints meet in K only if they
/// share a body. So K is as sparse as the mechanism. Its envelope stays narrow. Joints between the
/// same two bodies are one there (joint_groups.hpp).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/joints/joint_groups.hpp>
#include <bristle/dynamics/joints/joint_order.hpp>
#include <bristle/math/block_envelope.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// A body of a mechanism, at the start of a step. Its load has gravity in it, which a `Body` does
/// not know. So the integrator of mechanisms serves without a world.
template <Scalar S>
struct MechanismBody {
  /// [-] True if forces move it. If not, its mass does not count. Its velocity is then constant.
  bool moves_by_forces = false;
  /// [kg] Mass, > 0.
  S mass = S(1);
  /// [kg m^2], [1/(kg m^2)] Inertia about the centre of mass along the body's axes. Its inverse.
  Mat3<S> inertia_B = identity<Mat3<S>>();
  Mat3<S> inverse_inertia_B = identity<Mat3<S>>();
  /// [-] World axes along and about which it does not move. Its velocity there is zero.
  LockedAxes locked{};
  /// [m] Centre of mass in the world; [1] axes of the body.
  Transform<S> center_pose{};
  /// [m/s, rad/s] Velocity of the centre of mass and angular velocity, world axes.
  Twist<S> twist{};
  /// [N, N m] Total of forces and torques, with gravity. It is about the centre of mass along world
  /// axes. Constant over the step.
  Wrench<S> load{};
  /// [1/s] Rates at which forces besides those of joints let velocity and angular momentum decay.
  S linear_damping = S(0);
  S angular_damping = S(0);
};

/// A body of a world. Loads are the world's gravity [m/s^2] and the caller's wrench.
template <Scalar S>
[[nodiscard]] MechanismBody<S> mechanism_body(const Body<S>& body, const Vec3<S>& gravity);

/// Bodies and joints at the positions of the last `place`. Also the matrix of the last `factor`.
template <Scalar S>
class JointSystem {
 public:
  /// A body, and its change in the last `solve`. It exists beside `MechanismBody` since a step
  /// evaluates many states of one input.
  struct Node {
    const MechanismBody<S>* def = nullptr;
    BodyState<S> now{};
    Vec3<S> inverse_mass = zero<Vec3<S>>();     // World axes.
    Mat3<S> inverse_inertia = zero<Mat3<S>>();  // World axes.
    Twist<S> acceleration{};                    // For the user of this class.
    Wrench<S> load{};
    Twist<S> change{};
    bool is_diagonal = false;  // Its axes are principal axes: cheaper to turn.
  };

  /// Sets bodies and joints, at their first instant. Bodies must stay alive while in use.
  void set(std::span<const MechanismBody<S>> bodies, std::span<const MechanismJoint<S>> joints);

  [[nodiscard]] std::span<Node> nodes() { return nodes_; }
  [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }
  /// Joints as they are solved: see `JointGroups::orient`.
  [[nodiscard]] std::span<const MechanismJoint<S>> joints() const { return joints_; }
  [[nodiscard]] const JointState<S>& at(std::size_t joint) const { return at_[joint]; }
  /// [m] Largest present arm of a joint. Without one it is the largest radius of gyration. This is
  /// the size of the mechanism's parts. Angles count as gaps by it.
  [[nodiscard]] S size() const;

  /// Updates arms of joints and inertias in world axes from the positions in `Node::now`.
  void place();
  /// Builds and factors the matrix at the positions of the last `place`.
  /// @return False if it is singular, not finite, or too wide (`chosen::most_factor_work`).
  [[nodiscard]] bool factor();
  /// Finds the wrenches, or impulses, that give each joint the relative motion b. Finds the
  /// `change` of motion of each body.
  void solve(std::span<const Twist<S>> b);
  /// Result of `solve`: the wrench of each joint on its B as given to `set`. It is about B's joint
  /// origin, world axes.
  [[nodiscard]] std::span<const Wrench<S>> wrenches() const { return wrenches_; }

  /// J times a motion of the bodies: `motion(node)` is a twist.
  template <typename Motion>
  [[nodiscard]] Twist<S> held(std::size_t joint, const Motion& motion) const {
    const MechanismJoint<S>& def = joints_[joint];
    return constraint_velocity(def.kind, at_[joint], motion(nodes_[def.body_a]),
                               motion(nodes_[def.body_b]));
  }
  /// [m, rad] Position error of a joint.
  [[nodiscard]] Twist<S> gap(std::size_t joint) const {
    const MechanismJoint<S>& def = joints_[joint];
    return constraint_error(def, at_[joint], nodes_[def.body_a].now, nodes_[def.body_b].now);
  }

 private:
  [[nodiscard]] bool has_same_topology(std::span<const MechanismBody<S>> bodies,
                                       std::span<const MechanismJoint<S>> joints) const;
  void set_inverse_inertia(Node& node) const;
  [[nodiscard]] JointKind kind(std::size_t group) const { return groups_.joints()[group].kind; }
  void couple(const JointCoupling& coupling, const Mat3<S>& lever);
  void couple_merged(const JointCoupling& coupling, const Mat3<S>& lever);
  /// [1/kg] or [1/(kg m^2)] Mean mobility of the bodies of a joint, without arms.
  [[nodiscard]] S mobility_of(const MechanismJoint<S>& joint, bool is_linear) const;
  void fill_free_rows();
  void add_solution(std::span<const Twist<S>> b);
  void add_wrench(std::size_t joint, const Vec3<S>& linear, const Vec3<S>& angular);

  DynamicArray<MechanismJoint<S>> joints_;
  DynamicArray<Node> nodes_;
  DynamicArray<JointState<S>> at_;
  JointGroups<S> groups_;
  JointOrder order_;          // Order of groups.
  DynamicArray<bool> moves_;  // Topology of `order_`, with the two below.
  DynamicArray<JointKind> kinds_;
  DynamicArray<std::array<std::uint32_t, 2>> pairs_;
  bool may_be_singular_ = false;
  BlockEnvelope<S> matrix_;
  DynamicArray<Vec3<S>> rows_;
  DynamicArray<Twist<S>> rest_;
  DynamicArray<Wrench<S>> wrenches_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
MechanismBody<S> mechanism_body(const Body<S>& body, const Vec3<S>& gravity) {
  MechanismBody<S> out;
  out.moves_by_forces = body.is_dynamic();
  out.center_pose = body.center_pose;
  if (body.motion != Motion::fixed) out.twist = body.twist;
  if (!out.moves_by_forces) return out;
  out.mass = body.mass;
  out.inertia_B = body.inertia_B;
  out.inverse_inertia_B = body.inverse_inertia_B;
  out.locked = body.locked;
  out.linear_damping = body.linear_damping;
  out.angular_damping = body.angular_damping;
  out.load = body.applied;
  out.load.force += body.mass * body.gravity_scale * gravity;
  return out;
}

template <Scalar S>
bool JointSystem<S>::has_same_topology(std::span<const MechanismBody<S>> bodies,
                                       std::span<const MechanismJoint<S>> joints) const {
  if (moves_.size() != bodies.size() || kinds_.size() != joints.size()) return false;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (moves_[i] != bodies[i].moves_by_forces) return false;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (kinds_[i] != joints[i].kind || pairs_[i][0] != joints[i].body_a ||
        pairs_[i][1] != joints[i].body_b) {
      return false;
    }
  }
  return true;
}

template <Scalar S>
void JointSystem<S>::set(std::span<const MechanismBody<S>> bodies,
                         std::span<const MechanismJoint<S>> joints) {
  if (!has_same_topology(bodies, joints)) {
    moves_.clear();
    kinds_.clear();
    pairs_.clear();
    for (const MechanismBody<S>& body : bodies) moves_.push_back(body.moves_by_forces);
    for (const MechanismJoint<S>& joint : joints) {
      kinds_.push_back(joint.kind);
      pairs_.push_back({joint.body_a, joint.body_b});
    }
    groups_.build(joints, moves_);
    order_.build(groups_.joints(), moves_);
    matrix_.set_shape(order_.envelope());
  }
  groups_.orient(joints, joints_);
  may_be_singular_ = order_.has_loop() || groups_.has_merged();
  nodes_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const MechanismBody<S>& def = bodies[i];
    Node& node = nodes_[i];
    node = Node{};
    node.def = &def;
    node.now.x = def.center_pose.translation;
    node.now.set_axes(def.center_pose.rotation);
    node.now.twist = def.twist;
    if (!def.moves_by_forces) continue;
    const Mat3<S>& inverse = def.inverse_inertia_B;
    node.is_diagonal = inverse(1, 0) == S(0) && inverse(2, 0) == S(0) && inverse(2, 1) == S(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      may_be_singular_ = may_be_singular_ || def.locked.linear[axis] || def.locked.angular[axis];
      if (!def.locked.linear[axis]) {
        node.inverse_mass[static_cast<Eigen::Index>(axis)] = S(1) / def.mass;
      }
    }
  }
  at_.resize(joints.size());
  rest_.resize(joints.size());
  wrenches_.resize(joints.size());
  rows_.resize(order_.envelope().size());
  place();
}

template <Scalar S>
S JointSystem<S>::size() const {
  using std::max;
  using std::sqrt;
  S largest2 = S(0);
  for (const JointState<S>& at : at_) {
    largest2 = max(largest2, max(at.arm_a.squaredNorm(), at.arm_b.squaredNorm()));
  }
  if (largest2 > S(0)) return sqrt(largest2);
  for (const Node& node : nodes_) {
    if (!node.def->moves_by_forces) continue;
    largest2 = max(largest2, S(0.5) * node.def->inertia_B.trace() / node.def->mass);
  }
  return sqrt(largest2);
}

/// Sets the inverse inertia of the free axes. Torques turn the body about those alone.
template <Scalar S>
void JointSystem<S>::set_inverse_inertia(Node& node) const {
  const Mat3<S>& R = node.now.R;
  const LockedAxes& locked = node.def->locked;
  if (!locked.any_angular()) {
    const Mat3<S>& inverse = node.def->inverse_inertia_B;
    Mat3<S> half;
    if (node.is_diagonal) {
      half = R * diagonal_matrix<S>(diagonal_of<S>(inverse));
    } else {
      half = R * inverse;
    }
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) {
        node.inverse_inertia(i, j) = node.inverse_inertia(j, i) = row_of(half, i).dot(row_of(R, j));
      }
    }
    return;
  }
  node.inverse_inertia =
      inverse_inertia<S>(R * node.def->inertia_B * R.transpose(), locked.angular);
}

template <Scalar S>
void JointSystem<S>::place() {
  for (Node& node : nodes_) {
    if (node.def->moves_by_forces) set_inverse_inertia(node);
  }
  groups_.place(joints_, nodes_, at_);
}

/// Adds the coupling of two joints through a body. A unit impulse at the arm r changes the velocity
/// at the arm s by 1/m - [s] I^-1 [r]. A unit torque changes it by -[s] I^-1.
/// @param lever  -[s] I^-1 of the row's joint.
template <Scalar S>
void JointSystem<S>::couple(const JointCoupling& coupling, const Mat3<S>& lever) {
  const Node& node = nodes_[coupling.body];
  const JointState<S>& row = groups_.at(coupling.row);
  const JointState<S>& column = groups_.at(coupling.column);
  const bool row_slides = lets_slide(kind(coupling.row));
  const bool column_slides = lets_slide(kind(coupling.column));
  const std::size_t i = order_.first_row(coupling.row);
  const std::size_t j = order_.first_row(coupling.column);
  const S sign = coupling.is_b_of_row == coupling.is_b_of_column ? S(1) : S(-1);
  const Vec3<S> r = sign * (coupling.is_b_of_column ? column.arm_b : column.arm_a);

  Mat3<S> linear = times_skew<S>(lever, r);
  linear += sign * diagonal_matrix<S>(node.inverse_mass);
  if (row_slides) linear -= row.slide * (row.slide.transpose() * linear);
  if (column_slides) linear -= (linear * column.slide) * column.slide.transpose();
  matrix_.at(i, j) += linear;

  const bool row_turns = lets_turn(kind(coupling.row));
  const bool column_turns = lets_turn(kind(coupling.column));
  if (!row_turns) {
    const bool row_hinges = lets_hinge(kind(coupling.row));
    Mat3<S> block = times_skew<S>(node.inverse_inertia, r);
    if (column_slides) block -= (block * column.slide) * column.slide.transpose();
    if (row_hinges) block -= row.hinge * (row.hinge.transpose() * block);
    matrix_.at(i + 1, j) += block;
    if (!column_turns) {
      block = sign * node.inverse_inertia;
      if (row_hinges) block -= row.hinge * (row.hinge.transpose() * block);
      if (lets_hinge(kind(coupling.column))) {
        block -= (block * column.hinge) * column.hinge.transpose();
      }
      matrix_.at(i + 1, j + 1) += block;
    }
  }
  if (!column_turns && i != j) {
    Mat3<S> block = sign * lever;
    if (row_slides) block -= row.slide * (row.slide.transpose() * block);
    if (lets_hinge(kind(coupling.column))) {
      block -= (block * column.hinge) * column.hinge.transpose();
    }
    matrix_.at(i, j + 1) += block;
  }
}

/// The same if one of the two is a group of several joints. The rows of the group are a triangle
/// times other rows. Those are the rows that `couple` finds for a joint that holds all.
template <Scalar S>
void JointSystem<S>::couple_merged(const JointCoupling& coupling, const Mat3<S>& lever) {
  const Node& node = nodes_[coupling.body];
  const JointState<S>& column = groups_.at(coupling.column);
  const std::size_t i = order_.first_row(coupling.row);
  const std::size_t j = order_.first_row(coupling.column);
  const S sign = coupling.is_b_of_row == coupling.is_b_of_column ? S(1) : S(-1);
  const Vec3<S> r = sign * (coupling.is_b_of_column ? column.arm_b : column.arm_a);
  Mat6<S> block;
  set_quarter<0, 0, S>(block,
                       times_skew<S>(lever, r) + sign * diagonal_matrix<S>(node.inverse_mass));
  set_quarter<0, 3, S>(block, sign * lever);
  set_quarter<3, 0, S>(block, times_skew<S>(node.inverse_inertia, r));
  set_quarter<3, 3, S>(block, sign * node.inverse_inertia);
  const auto rows_of = [&](std::size_t group) -> Mat6<S> {
    if (groups_.is_merged(group)) return groups_.triangle(group);
    const JointState<S>& at = groups_.at(group);
    const Mat3<S> one = identity<Mat3<S>>();
    Mat6<S> rows = zero<Mat6<S>>();
    set_quarter<0, 0, S>(rows, one - at.slide * at.slide.transpose());
    set_quarter<3, 3, S>(rows, one - at.hinge * at.hinge.transpose());
    return rows;
  };
  const Mat6<S> half = rows_of(coupling.row) * block;
  block = half * rows_of(coupling.column).transpose();
  const bool has_below = !lets_turn(kind(coupling.row));
  const bool has_right = !lets_turn(kind(coupling.column));
  matrix_.at(i, j) += quarter<0, 0, S>(block);
  if (has_below) matrix_.at(i + 1, j) += quarter<3, 0, S>(block);
  if (has_below && has_right) {
    matrix_.at(i + 1, j + 1) += quarter<3, 3, S>(block);
  }
  if (has_right && i != j) matrix_.at(i, j + 1) += quarter<0, 3, S>(block);
}

template <Scalar S>
S JointSystem<S>::mobility_of(const MechanismJoint<S>& joint, bool is_linear) const {
  S sum = S(0);
  for (const std::uint32_t body : {joint.body_a, joint.body_b}) {
    const Node& node = nodes_[body];
    sum += is_linear ? node.inverse_mass.sum() : node.inverse_inertia.trace();
  }
  return sum / S(3);
}

/// Makes the matrix regular where it is singular by design. It is so along slides and about hinges.
/// No row holds these. It is so, too, where loops or locked axes leave more rows than can move. The
/// added terms are small. The second pass of `solve` removes their effect on everything that can
/// move.
template <Scalar S>
void JointSystem<S>::fill_free_rows() {
  const S share = may_be_singular_ ? Tolerance<S>::equal() : S(0);
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const JointKind kind = this->kind(i);
    if (!may_be_singular_ && !lets_slide(kind) && !lets_hinge(kind)) continue;
    const std::size_t row = order_.first_row(i);
    const std::size_t rows = lets_turn(kind) ? 1 : 2;
    // All rows of a triangle but the first three may be zero.
    const S mean =
        groups_.is_merged(i)
            ? S((matrix_.at(row, row).trace() + matrix_.at(row + 1, row + 1).trace()) / S(6))
            : S(0);
    for (std::size_t r = row; r < row + rows; ++r) {
      Mat3<S>& block = matrix_.at(r, r);
      S scale = groups_.is_merged(i) ? mean : S(block.trace() / S(3));
      // Where locked axes leave nothing that the row could hold, what is left is round-off.
      const S own = mobility_of(groups_.joints()[i], r == row);
      if (!(scale > Tolerance<S>::equal() * own)) scale = own;
      if (value_of(scale) == 0) scale = S(1);
      const Vec3<S>& axis = r == row ? groups_.at(i).slide : groups_.at(i).hinge;
      block += (scale * axis) * axis.transpose();
      block += (share * scale) * identity<Mat3<S>>();
    }
  }
}

template <Scalar S>
bool JointSystem<S>::factor() {
  if (order_.is_too_wide()) return false;
  groups_.reduce(joints_, at_);
  matrix_.set_zero();
  Mat3<S> lever;
  const JointCoupling* before = nullptr;
  for (const JointCoupling& coupling : order_.couplings()) {
    if (before == nullptr || before->row != coupling.row || before->body != coupling.body) {
      const JointState<S>& at = groups_.at(coupling.row);
      const Vec3<S>& s = coupling.is_b_of_row ? at.arm_b : at.arm_a;
      // -[s] I^-1 is the transpose of I^-1 [s].
      lever = transposed(times_skew<S>(nodes_[coupling.body].inverse_inertia, s));
    }
    if (groups_.is_merged(coupling.row) || groups_.is_merged(coupling.column)) {
      couple_merged(coupling, lever);
    } else {
      couple(coupling, lever);
    }
    before = &coupling;
  }
  fill_free_rows();
  return matrix_.factor();
}

/// Adds the impulses of a joint's rows to its bodies. Parts along its free axes have no meaning and
/// are removed.
template <Scalar S>
void JointSystem<S>::add_wrench(std::size_t i, const Vec3<S>& linear, const Vec3<S>& angular) {
  const JointState<S>& at = at_[i];
  const JointKind kind = joints_[i].kind;
  const Vec3<S> force = lets_slide(kind) ? across(at.slide, linear) : linear;
  Wrench<S>& load_a = nodes_[joints_[i].body_a].load;
  Wrench<S>& load_b = nodes_[joints_[i].body_b].load;
  Wrench<S> wrench{force, zero<Vec3<S>>()};
  load_b.force += force;
  load_a.force -= force;
  load_b.torque += at.arm_b.cross(force);
  load_a.torque -= at.arm_a.cross(force);
  if (!lets_turn(kind)) {
    wrench.torque = lets_hinge(kind) ? across(at.hinge, angular) : angular;
    load_b.torque += wrench.torque;
    load_a.torque -= wrench.torque;
  }
  if (groups_.is_exchanged(i)) {
    // Acts on the other body, about its own origin.
    const Node& a = nodes_[joints_[i].body_a];
    const Vec3<S> origin = a.now.R * joints_[i].X_CmA_J.translation;
    wrench = -wrench.shifted(origin - at.arm_a);
  }
  wrenches_[i] += wrench;
}

/// Solves for b and adds the wrenches. Adds their effect on the bodies.
template <Scalar S>
void JointSystem<S>::add_solution(std::span<const Twist<S>> b) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::size_t row = order_.first_row(g);
    if (groups_.is_merged(g)) {
      groups_.gather(g, joints_, b, rows_[row], rows_[row + 1]);
      continue;
    }
    rows_[row] = b[groups_.joint(g)].linear;
    if (!lets_turn(kind(g))) rows_[row + 1] = b[groups_.joint(g)].angular;
  }
  matrix_.solve(rows_);
  for (Node& node : nodes_) node.load = {};
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::size_t row = order_.first_row(g);
    const std::size_t last = row + (lets_turn(kind(g)) ? 0 : 1);
    if (groups_.is_merged(g)) {
      groups_.broadcast(g, joints_, rows_[row], rows_[last],
                        [this](std::size_t joint, const Vec3<S>& linear, const Vec3<S>& angular) {
                          add_wrench(joint, linear, angular);
                        });
    } else {
      add_wrench(groups_.joint(g), rows_[row], rows_[last]);
    }
  }
  for (Node& node : nodes_) {
    if (!node.def->moves_by_forces) continue;
    node.change.linear += cwise_product(node.inverse_mass, node.load.force);
    node.change.angular += node.inverse_inertia * node.load.torque;
  }
}

template <Scalar S>
void JointSystem<S>::solve(std::span<const Twist<S>> b) {
  for (Wrench<S>& wrench : wrenches_) wrench = {};
  for (Node& node : nodes_) node.change = {};
  add_solution(b);
  if (!may_be_singular_) return;
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    rest_[i] = b[i] - held(i, [](const Node& node) -> const Twist<S>& { return node.change; });
  }
  add_solution(rest_);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
