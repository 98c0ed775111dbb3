// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/matrix_arithmetic.hpp>
#include <bristle/math/types.hpp>

#include <doctest/doctest.h>

#include <concepts>
#include <limits>
#include <random>

namespace {

/// Eigen's operators: outside the namespace of the library nothing else is found.
namespace eigen {
const auto sum = [](const auto& a, const auto& b) { return (a + b).eval(); };
const auto difference = [](const auto& a, const auto& b) { return (a - b).eval(); };
const auto product = [](const auto& a, const auto& b) { return (a * b).eval(); };
const auto quotient = [](const auto& a, const auto& b) { return (a / b).eval(); };
const auto negative = [](const auto& a) { return (-a).eval(); };
}  // namespace eigen

}  // namespace

namespace bristle {
namespace {

template <typename Matrix>
Matrix random_matrix(std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  Matrix m;
  for (Eigen::Index i = 0; i < m.size(); ++i) {
    m.data()[i] = static_cast<typename Matrix::Scalar>(number(random));
  }
  return m;
}

TEST_CASE_TEMPLATE("matrix_arithmetic: gives values, and those of Eigen's expressions", S, float,
                   double) {
  std::mt19937 random(1);
  for (int round = 0; round < 100; ++round) {
    const auto a = random_matrix<Vec3<S>>(random), b = random_matrix<Vec3<S>>(random);
    const auto M = random_matrix<Mat3<S>>(random), N = random_matrix<Mat3<S>>(random);
    const auto x = random_matrix<bristle::Vec6<S>>(random),
               y = random_matrix<bristle::Vec6<S>>(random);
    const auto K = random_matrix<Mat6<S>>(random);
    const S k = a.x();
    // Sums of up to six products of numbers up to 1, made in other orders, in up to 36 entries:
    // each is off by five roundings of at most six.
    const S tolerance = S(6 * 30) * std::numeric_limits<S>::epsilon();
    static_assert(std::same_as<decltype(a + b), Vec3<S>>);
    static_assert(std::same_as<decltype(x - y), bristle::Vec6<S>>);
    static_assert(std::same_as<decltype(k * x), bristle::Vec6<S>>);
    static_assert(std::same_as<decltype(M * a), Vec3<S>>);
    static_assert(std::same_as<decltype(K * x), bristle::Vec6<S>>);
    static_assert(std::same_as<decltype(M.transpose() * N), Mat3<S>>);
    static_assert(std::same_as<decltype(a * b.transpose()), Mat3<S>>);
    CHECK(a + b == eigen::sum(a, b));
    CHECK(M - N == eigen::difference(M, N));
    CHECK(-x == eigen::negative(x));
    CHECK(k * M == eigen::product(k, M));
    CHECK(a * k == eigen::product(a, k));
    CHECK(x / k == eigen::quotient(x, k));
    CHECK((M * a - eigen::product(M, a)).norm() < tolerance);
    CHECK((M * N - eigen::product(M, N)).norm() < tolerance);
    CHECK(a * b.transpose() == eigen::product(a, b.transpose()));
    // Parts of matrices and expressions, which are evaluated first.
    CHECK((M.transpose() * a - eigen::product(M.transpose(), a)).norm() < tolerance);
    CHECK((M * N.transpose() - eigen::product(M, N.transpose())).norm() < tolerance);
    CHECK(M.col(1) + b == eigen::sum(M.col(1), b));
    CHECK(M.row(2) - N.row(0) == eigen::difference(M.row(2), N.row(0)));
    CHECK((M.row(1) * a - eigen::product(M.row(1), a)).norm() < tolerance);
    CHECK(x.template tail<3>() - a == eigen::difference(x.template tail<3>(), a));
    CHECK(a.cwiseAbs() + b == eigen::sum(a.cwiseAbs(), b));
    CHECK(M + Mat3<S>::Identity() == eigen::sum(M, Mat3<S>::Identity()));
    CHECK((K * x - eigen::product(K, x)).norm() < tolerance);
    CHECK((K * K.transpose() - eigen::product(K, K.transpose())).norm() < tolerance);
  }
}

TEST_CASE_TEMPLATE("matrix_arithmetic: entry by entry as Eigen, with the same bits", S, float,
                   double) {
  std::mt19937 random(2);
  for (int round = 0; round < 100; ++round) {
    const auto a = random_matrix<Vec3<S>>(random), b = random_matrix<Vec3<S>>(random);
    const auto M = random_matrix<Mat3<S>>(random), N = random_matrix<Mat3<S>>(random);
    static_assert(std::same_as<decltype(cwise_abs(a - b)), Vec3<S>>);
    CHECK(cwise_abs(M) == M.cwiseAbs());
    CHECK(cwise_square(a) == a.cwiseAbs2());
    CHECK(cwise_inverse(a) == a.cwiseInverse());
    CHECK(cwise_product(a, b) == a.cwiseProduct(b));
    CHECK(cwise_min(M, N) == M.cwiseMin(N));
    CHECK(cwise_max(a, b) == a.cwiseMax(b));
    CHECK(cwise_clamp(a, S(0.25)) == a.cwiseMax(S(-0.25)).cwiseMin(S(0.25)));
    CHECK(all_at_most(a, b) == (a.array() <= b.array()).all());
    CHECK(all_at_most(a, a));
    CHECK(detail::row_of(M, 1) == M.row(1).transpose());
    CHECK(detail::column_of(M, 2) == M.col(2));
    CHECK(detail::diagonal_of(M) == M.diagonal());
    CHECK(detail::diagonal_matrix(a) == Mat3<S>(a.asDiagonal()));
    CHECK(detail::transposed(M) == M.transpose());
    CHECK(detail::xy_of(a) == a.template head<2>());
    Mat3<S> set = M;
    detail::set_row(set, 0, a);
    detail::set_column(set, 2, b);
    Mat3<S> expected = M;
    expected.row(0) = a;
    expected.col(2) = b;
    CHECK(set == expected);
    const Mat3<S> mirrored =
        detail::symmetric(M(0, 0), M(0, 1), M(0, 2), M(1, 1), M(1, 2), M(2, 2));
    CHECK(mirrored == Mat3<S>(M.template selfadjointView<Eigen::Upper>()));
  }
  const S nan = std::numeric_limits<S>::quiet_NaN();
  CHECK(!all_at_most(Vec3<S>(0, nan, 0), Vec3<S>(1, 1, 1)));
}

TEST_CASE("matrix_arithmetic: leaves to Eigen other sizes, other scalars and inner products") {
  const Eigen::VectorXd a = Eigen::VectorXd::Ones(4);
  CHECK((a + a).sum() == 8.0);
  CHECK((2 * Vec3<double>(1, 2, 3)).sum() == 12.0);
  const Vec3<double> b(1, 2, 3);
  const double inner = b.transpose() * b;
  CHECK(inner == 14.0);
}

TEST_CASE_TEMPLATE("matrix_arithmetic: constants, and comparisons of all entries", S, float,
                   double) {
  const auto check_constants = []<typename M>(const M& /*unused*/) {
    CHECK(M(detail::zero<M>()).isZero(S(0)));
    CHECK(M(detail::filled<M>(S(3)) - M::Constant(S(3))).isZero(S(0)));
    M m = detail::filled<M>(S(3));
    detail::set_zero(m);
    CHECK(m.isZero(S(0)));
  };
  check_constants(detail::Vec2<S>());
  check_constants(Vec3<S>());
  check_constants(bristle::Vec6<S>());
  check_constants(Mat3<S>());
  check_constants(Mat6<S>());
  CHECK(Mat3<S>(detail::identity<Mat3<S>>() - Mat3<S>::Identity()).isZero(S(0)));
  CHECK(Mat6<S>(detail::identity<Mat6<S>>() - Mat6<S>::Identity()).isZero(S(0)));
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(Vec3<S>(detail::unit_vector<Vec3<S>>(axis) - Vec3<S>::Unit(axis)).isZero(S(0)));
  }
  CHECK(detail::unit_x<Vec3<S>>() == Vec3<S>(1, 0, 0));
  CHECK(detail::unit_y<Vec3<S>>() == Vec3<S>(0, 1, 0));
  CHECK(detail::unit_z<Vec3<S>>() == Vec3<S>(0, 0, 1));
  // Entry (1, 0) of a matrix that is stored by rows.
  using Rows = Eigen::Matrix<S, 2, 3, Eigen::RowMajor>;
  const auto by_rows = detail::matrix_of<Rows>([](int i, int j) { return S(10 * i + j); });
  CHECK(by_rows(1, 0) == S(10));
  CHECK(by_rows(0, 2) == S(2));

  // Compared out here: doctest would compare where only Eigen's operators are found.
  const auto are_equal = [](const auto& a, const auto& b) {
    const bool is_equal = a == b, differs = a != b;
    CHECK(is_equal == !differs);
    return is_equal;
  };
  const Mat3<S> one = detail::identity<Mat3<S>>();
  CHECK(are_equal(one, one));
  for (int i = 0; i < 9; ++i) {
    Mat3<S> m = one;
    m.data()[i] += S(2);
    CHECK_FALSE(are_equal(m, one));
    CHECK(are_equal(m.transpose(), Eigen::Matrix<S, 3, 3, Eigen::RowMajor>(m.transpose())));
    CHECK(are_equal(m.row(i % 3), m.transpose().col(i % 3).transpose()));
    CHECK(are_equal(m * one, m));
    m.data()[i] = std::numeric_limits<S>::quiet_NaN();
    CHECK_FALSE(are_equal(m, m));
  }
}

TEST_CASE_TEMPLATE("inverse_of: the inverse by cofactors, as Eigen's", S, float, double) {
  std::mt19937 random(5);
  for (int round = 0; round < 100; ++round) {
    const auto M = random_matrix<Mat3<S>>(random);
    const Mat3<S> inverse = detail::inverse_of(M);
    // A cofactor is off by two roundings of at most 2, the determinant by ten of at most 6. Both
    // are divided by the determinant.
    const S determinant = std::abs(M.determinant());
    const S tolerance = S(64) * std::numeric_limits<S>::epsilon() *
                        (S(1) + inverse.cwiseAbs().maxCoeff()) / determinant;
    CHECK((inverse - M.inverse()).cwiseAbs().maxCoeff() <= tolerance);
    CHECK((M * inverse - Mat3<S>::Identity()).cwiseAbs().maxCoeff() <= S(3) * tolerance);
  }
}

TEST_CASE_TEMPLATE("rotated: R M R^T of a symmetric M", S, float, double) {
  Mat3<S> M;
  M << S(3), S(0.5), S(-0.25), S(0.5), S(2), S(0.125), S(-0.25), S(0.125), S(1);
  const Mat3<S> R = Quat<S>(S(0.5), S(-0.1), S(0.7), S(0.3)).normalized().toRotationMatrix();
  const Mat3<S> difference = detail::rotated<S>(R, M) - R * M * R.transpose();
  // Entries of order 3, sums of nine products.
  CHECK(difference.cwiseAbs().maxCoeff() < S(3) * bristle::detail::Tolerance<S>::round_off());
  CHECK(detail::rotated<S>(R, M) == detail::rotated<S>(R, M).transpose());
}

}  // namespace
}  // namespace bristle
