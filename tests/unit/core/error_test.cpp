// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/error.hpp>

#include <Eigen/Core>
#include <doctest/doctest.h>

#include <limits>

using namespace bristle;

namespace {
template <typename Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return {};
}
}  // namespace

TEST_CASE("InvalidArgument: reads as field, value and rule") {
  const InvalidArgument error("BodyDef::mass", "-1", "must be finite and > 0");
  CHECK(std::string(error.what()) == "BodyDef::mass = -1: must be finite and > 0");
  CHECK(error.field() == "BodyDef::mass");
  CHECK(error.value() == "-1");
  CHECK(error.rule() == "must be finite and > 0");
}

TEST_CASE("IoError: reads as file, line and reason; without a line where there is none") {
  const IoError text("part.obj", 12, "face with 2 corners");
  CHECK(std::string(text.what()) == "part.obj:12: face with 2 corners");
  CHECK(text.file() == "part.obj");
  CHECK(text.line() == 12);
  CHECK(std::string(IoError("a.stl", 0, "truncated").what()) == "a.stl: truncated");
}

TEST_CASE_TEMPLATE("require: passes what holds and names what does not", S, float, double) {
  constexpr S nan_ = std::numeric_limits<S>::quiet_NaN();
  constexpr S inf = std::numeric_limits<S>::infinity();
  using namespace bristle::detail;
  CHECK(message_of([=] { require_positive("x", S(1)); }).empty());
  CHECK(message_of([=] { require_not_negative("x", S(0)); }).empty());
  CHECK(message_of([=] { require_finite("x", S(-3)); }).empty());
  CHECK(message_of([=] { require_positive("x", S(0)); }) == "x = 0: must be finite and > 0");
  CHECK(message_of([=] { require_positive("x", inf); }) == "x = inf: must be finite and > 0");
  CHECK(message_of([=] { require_not_negative("x", S(-0.5)); }) ==
        "x = -0.5: must be finite and >= 0");
  CHECK_FALSE(message_of([=] { require_positive("x", nan_); }).empty());
  CHECK_FALSE(message_of([=] { require_finite("x", nan_); }).empty());
  Eigen::Matrix<S, 3, 1> v(S(1), nan_, S(3));
  CHECK(message_of([&] { require_all_finite("v", v); }).starts_with("v[1] = "));
}
