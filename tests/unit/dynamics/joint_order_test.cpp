// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/joints/joint_order.hpp>

#include <doctest/doctest.h>

#include <array>

using namespace bristle;

using namespace bristle::detail;

namespace {

MechanismJoint<double> between(std::uint32_t a, std::uint32_t b, JointKind kind = JointKind::ball) {
  MechanismJoint<double> joint;
  joint.kind = kind;
  joint.body_a = a;
  joint.body_b = b;
  return joint;
}

JointOrder order_of(DynamicArray<MechanismJoint<double>> joints, const DynamicArray<bool>& moves) {
  JointOrder order;
  order.build<double>(joints, moves);
  return order;
}

}  // namespace

TEST_CASE("JointOrder: a chain given in disorder reaches back by one joint only") {
  const JointOrder order =
      order_of({between(3, 2), between(0, 1), between(4, 3), between(1, 2), between(5, 4)},
               {false, true, true, true, true, true});
  for (std::size_t row = 0; row < order.envelope().size(); ++row) {
    CHECK(order.envelope()[row] == (row == 0 ? 0 : row - 1));
  }
  CHECK_FALSE(order.has_loop());
  // Five joints with themselves through nine ends that move, and four neighbours.
  CHECK(order.couplings().size() == 9 + 4);
}

TEST_CASE("JointOrder: joints that let nothing turn take two rows") {
  const JointOrder order = order_of({between(0, 1), between(1, 2, JointKind::fixed), between(2, 3)},
                                    {false, true, true, true});
  CHECK(order.envelope().size() == 4);
  CHECK(order.first_row(2) - order.first_row(0) == 3);
}

TEST_CASE("JointOrder: loops are found, through what does not move as well") {
  CHECK(order_of({between(0, 1), between(1, 2), between(2, 0)}, {true, true, true}).has_loop());
  CHECK(order_of({between(0, 1), between(1, 2)}, {false, true, false}).has_loop());
  CHECK_FALSE(order_of({between(0, 1), between(1, 2)}, {true, true, true}).has_loop());
}

TEST_CASE("JointOrder: groups that do not touch are both numbered") {
  const JointOrder order = order_of({between(0, 1), between(2, 3)}, {true, true, true, true});
  CHECK(order.envelope().size() == 2);
  CHECK(order.envelope()[1] == 1);
}
