/// @file
/// Tests of soft blocks between bodies that are known by their mobility.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/solver/soft_system.hpp>
#include <bristle/math/types.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Numbers in +-1, alike in each run.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : random_(seed) {}
  double operator()() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  template <typename Matrix>
  Matrix matrix() {
    Matrix m;
    for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = (*this)();
    return m;
  }
  template <typename S>
  Mat6<S> semidefinite(int rank, double size) {
    Mat6<double> sum = Mat6<double>::Zero();
    for (int i = 0; i < rank; ++i) {
      const Vec6<double> v = matrix<Vec6<double>>();
      sum += size * v * v.transpose();
    }
    return sum.template cast<S>();
  }

 private:
  std::mt19937 random_;
};

template <typename S>
Twist<S> twist(Numbers& numbers) {
  return {numbers.matrix<Vec3<double>>().cast<S>(), numbers.matrix<Vec3<double>>().cast<S>()};
}

template <typename S>
SoftBlock<S> block(Numbers& numbers, std::uint32_t a, std::uint32_t b, double stiffness) {
  SoftBlock<S> made;
  made.body_a = a;
  made.body_b = b;
  made.arm_a = numbers.matrix<Vec3<double>>().cast<S>();
  made.arm_b = numbers.matrix<Vec3<double>>().cast<S>();
  made.matrix = numbers.semidefinite<S>(6, stiffness);
  made.offset = numbers.matrix<Vec6<double>>().cast<S>();
  return made;
}

/// [N s, N m s] Impulse of a block on a body about its centre of mass, evaluated by the block.
template <typename S>
Wrench<S> on_body(const SoftBlock<S>& block, std::uint32_t body) {
  const Vec6<S> p = block.offset + block.matrix * block.motion;
  const Wrench<S> on_b{p.template head<3>(), p.template tail<3>()};
  if (body == block.body_b) return on_b.shifted(-block.arm_b);
  if (body == block.body_a) return -on_b.shifted(-block.arm_a);
  return {};
}

}  // namespace

TEST_CASE_TEMPLATE("SoftSystem: bodies move by what the blocks give them at the motion found", S,
                   float, double) {
  Numbers numbers(3);
  for (const double stiffness : {0.1, 1e3}) {
    // 0 and 1 are links of one mechanism, 2 slides along one axis, 3 is led, 4 is free and alone.
    constexpr std::size_t count = 5;
    SoftSystem<S> system;
    std::array<Twist<S>, count> free;
    for (Twist<S>& t : free) {
      t = twist<S>(numbers);
      (void)system.add_body(t);
    }
    std::array<std::array<Mat6<S>, count>, count> W;
    for (auto& row : W) row.fill(Mat6<S>::Zero());
    // J M^-1 J^T of two links with three joints.
    const auto J = numbers.matrix<Eigen::Matrix<double, 12, 3>>();
    const Eigen::Matrix<double, 12, 12> of_mechanism = J * J.transpose();
    for (std::uint32_t i = 0; i < 2; ++i) {
      for (std::uint32_t j = 0; j < 2; ++j) {
        W[i][j] = of_mechanism.block<6, 6>(6 * i, 6 * j).cast<S>();
      }
    }
    W[2][2](0, 0) = S(3);
    W[4][4] = numbers.semidefinite<S>(6, 1);
    system.set_mobility(0, 0, W[0][0]);
    system.set_mobility(1, 1, W[1][1]);
    system.set_mobility(1, 0, W[1][0]);
    system.set_mobility(2, 2, W[2][2]);
    system.set_mobility(4, 4, W[4][4]);
    std::vector<SoftBlock<S>> blocks{
        block<S>(numbers, 0, 2, stiffness), block<S>(numbers, 2, 1, stiffness),
        block<S>(numbers, 3, 1, stiffness), block<S>(numbers, 3, 4, stiffness)};
    const Wrench<S> apply_impulse{{S(1), S(2), S(0)}, {S(0), S(0.5), S(0)}};
    system.apply_impulse(1, apply_impulse);
    system.solve(blocks);

    // Twists by V = V_free + W f.
    std::array<Vec6<S>, count> V;
    for (std::size_t i = 0; i < count; ++i) {
      V[i] = stacked<S>(free[i].linear, free[i].angular);
      for (std::uint32_t j = 0; j < count; ++j) {
        Wrench<S> f = j == 1 ? apply_impulse : Wrench<S>{};
        for (const SoftBlock<S>& b : blocks) f += on_body(b, j);
        V[i] += W[i][j] * stacked<S>(f.force, f.torque);
      }
    }
    // Impulses are stiffness times what rounding leaves of a motion, and move bodies again.
    const S tolerance = S(stiffness) * S(4e3) * Tolerance<S>::round_off();
    for (const SoftBlock<S>& b : blocks) {
      const auto of = [&](std::uint32_t i) {
        return Twist<S>{V[i].template head<3>(), V[i].template tail<3>()};
      };
      CHECK((relative_motion(b, of(b.body_a), of(b.body_b)) - b.motion).norm() <= tolerance);
    }
  }
}

TEST_CASE("SoftSystem: what nothing connects is solved as if alone, to the bit") {
  Numbers numbers(5);
  std::array<Twist<double>, 4> free;
  for (Twist<double>& t : free) t = twist<double>(numbers);
  const Mat6<double> W = numbers.semidefinite<double>(6, 1);
  std::vector<SoftBlock<double>> both{block<double>(numbers, 0, 1, 10),
                                      block<double>(numbers, 2, 3, 10)};
  SoftSystem<double> system;
  for (std::uint32_t i = 0; i < 4; ++i) {
    (void)system.add_body(free[i]);
    system.set_mobility(i, i, W);
  }
  std::vector<SoftBlock<double>> together = both;
  system.solve(together);
  for (std::uint32_t pair = 0; pair < 2; ++pair) {
    system.clear();
    for (std::uint32_t i = 0; i < 2; ++i) {
      (void)system.add_body(free[2 * pair + i]);
      system.set_mobility(i, i, W);
    }
    std::vector<SoftBlock<double>> alone{both[pair]};
    alone[0].body_a = 0;
    alone[0].body_b = 1;
    system.solve(alone);
    CHECK(alone[0].motion == together[pair].motion);
  }
}

/// Motion of a body of 1 g that moves along x at 1 m/s against a block on what does not move.
static Vec6<float> light_body_against(SoftBlock<float> block) {
  SoftSystem<float> system;
  (void)system.add_body({{1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}});
  (void)system.add_body({});
  system.set_mobility(0, 0, 1e3f * Mat6<float>::Identity());
  block.body_b = 1;
  std::vector<SoftBlock<float>> blocks{block};
  system.solve(blocks);
  return blocks[0].motion;
}

TEST_CASE("SoftSystem: stiff blocks on light bodies leave the motion bounded") {
  SoftBlock<float> stiff;
  stiff.arm_a = {0.0f, 0.1f, 0.0f};
  stiff.matrix = 1e5f * Mat6<float>::Identity();
  const Vec6<float> motion = light_body_against(stiff);
  // (1 + W Q)^-1 of 1e8.
  CHECK(motion.norm() < 2e-8f);
  CHECK(motion[0] > 0.0f);
}

TEST_CASE("SoftSystem: a block that is stiff along one axis leaves motion across it") {
  SoftBlock<float> stiff;
  const Vec3<float> n = Vec3<float>::Ones() / std::sqrt(3.0f);
  stiff.matrix.setZero();
  stiff.matrix.topLeftCorner<3, 3>() = 1e5f * n * n.transpose();
  // 1e8 beside 1 leaves nothing of the 1 in float. All entries of n n^T are one number, so that
  // nothing is stiff across n.
  const Vec3<float> across(2.0f / 3, -1.0f / 3, -1.0f / 3);
  CHECK((light_body_against(stiff).head<3>() - across).norm() < 1e-4f);
}
